"""The landing page: which robot is large, what is said of each, and where its button leads."""

import re
from datetime import timedelta

import pytest
from django.contrib.auth.models import AnonymousUser

from accounts import services
from operatorlog.models import Entry, Find, Piece, Round
from portal.live.snapshot import snapshot
from queueing import services as queue
from queueing.estimates import wait_if_joined
from queueing.models import Queue
from robots import services as robot_services
from robots.kit.clock import SYSTEM
from robots.models import Frame, Grant, Lease, Robot
from robots.states import Cycle, GrantEnd, GrantKind
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def robots(robot):
    """Two robots that are ready."""
    other = Robot.objects.create(slug="other", name="Other", driver=robot.driver, address="sim:other", enabled=True)
    Robot.objects.update(cycle=Cycle.READY)
    for one in (robot, other):
        Lease.objects.update_or_create(
            robot=one, defaults={"epoch": 1, "expires_at": SYSTEM.now() + timedelta(days=99)}
        )
    return robot, other


def shown(client):
    """Return what the landing page was drawn with."""
    return client.get("/").context


def picture(robot, grant=None, file="frames/x.jpg"):
    return Frame.objects.create(robot=robot, grant=grant, file=file, taken_at=SYSTEM.now(), stable=True)


def ended(robot, person, pictures=3):
    """A turn that is over, with so many pictures."""
    turn = drive(robot, person, SYSTEM.now())
    for number in range(pictures):
        picture(robot, turn.grant, f"frames/{turn.pk}-{number}.jpg")
    queue.end_turn(turn, GrantEnd.HOLDER, "ended", SYSTEM.now())
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.READY)
    return turn


def test_the_robot_that_somebody_drives_is_large_and_says_who_drives(robots, people, client):
    other = robots[1]
    people["ada"].clearances.create(robot=other, granted_at=SYSTEM.now())
    drive(other, people["ada"], SYSTEM.now())
    answer = client.get("/")
    assert answer.context["lead"]["robot"] == other
    assert "ada drives" in answer.content.decode()
    assert answer.context["loop"] is None
    assert "Your wait: at most" in answer.content.decode()


def test_else_the_one_that_moves_by_itself(robots, client):
    other = robots[1]
    Grant.objects.create(
        robot=other, kind=GrantKind.IDLE, epoch=1, opened_at=SYSTEM.now(), until=SYSTEM.now() + timedelta(minutes=1)
    )
    assert shown(client)["lead"]["robot"] == other


def test_else_the_one_that_was_driven_last_with_the_pictures_of_that_turn(robots, people, client):
    other = robots[1]
    people["ada"].clearances.create(robot=other, granted_at=SYSTEM.now())
    turn = ended(other, people["ada"])
    found = shown(client)
    assert found["lead"]["robot"] == other
    assert found["loop"]["turn"] == turn
    assert [url.rsplit("-")[-1] for url in found["loop"]["urls"]] == ["0.jpg", "1.jpg", "2.jpg"]


def test_hidden_pictures_are_neither_in_the_loop_nor_the_newest_in_the_log(robots, people, client):
    robot = robots[0]
    turn = ended(robot, people["ada"])
    frame = Frame.objects.filter(grant=turn.grant).first()
    entry = Entry.objects.create(
        turn=turn, author=people["ada"], robot=robot, text="A shell", written_at=SYSTEM.now(), frame=frame
    )
    found = shown(client)
    assert (found["pictured"], found["find"]) == (entry, None)
    entry.visibility = "hidden"
    entry.save()
    found = shown(client)
    assert found["pictured"] is None
    assert found["loop"] is None


@pytest.mark.parametrize("state", [{"cycle": Cycle.FAULT}, {"cycle": Cycle.LOCKED_OUT}, {"stop_latched": True}])
def test_a_robot_that_is_closed_is_not_large_and_says_no_wait(robots, client, state):
    robot, other = robots
    Robot.objects.filter(pk=robot.pk).update(**state)
    found = shown(client)
    assert (found["lead"]["robot"], found["drive"]) == (other, other)
    assert [card["wait"] for card in found["cards"]] == [""]
    Robot.objects.filter(pk=other.pk).update(**state)
    assert shown(client)["drive"] is None


def test_who_drives_or_waits_is_told_no_wait_of_somebody_who_joins(robots, people, client):
    robot, now = robots[0], SYSTEM.now()
    for name in ("ada", "bob"):
        queue.join(robot, people[name], now)
    queue.tick(now)
    queue.accept(robot, people["ada"], now)
    for name in ("ada", "bob"):
        client.force_login(people[name])
        found = shown(client)
        assert found["lead"]["wait"] == "", name
        assert [card["wait"] for card in found["cards"]] == ["Free now"], name
        told = snapshot(robot.slug, people[name], now, True)
        assert bool(told["turn"]["mine"]) or told["me"]["ticket"] is not None, "by which a script knows it"
    client.logout()
    assert shown(client)["lead"]["wait"].startswith("Your wait: ")


def test_a_robot_that_moves_by_itself_or_whose_queue_is_paused_is_not_called_free(robots, client):
    robot, other = robots
    Grant.objects.create(
        robot=other, kind=GrantKind.IDLE, epoch=1, opened_at=SYSTEM.now(), until=SYSTEM.now() + timedelta(minutes=1)
    )
    queue.queue_of(robot)
    Queue.objects.update(paused=True)
    html = client.get("/").content.decode()
    assert "Free now" not in html
    assert "Your wait: not known now" in html
    assert "Your wait: less than a minute" in html
    for one in robots:
        assert not snapshot(one.slug, AnonymousUser(), SYSTEM.now(), True)["robot"]["free"]


SOON = [
    ({}, None, 0, True),
    ({}, GrantKind.IDLE, 0, True),
    ({}, GrantKind.IDLE, 4, False),
    ({}, GrantKind.REST, 0, True),
    ({}, GrantKind.JOB, 0, False),
    ({}, GrantKind.UPKEEP, 0, False),
    ({"cycle": Cycle.HANDOVER}, None, 0, True),
    ({"cycle": Cycle.HANDOVER}, None, 4, False),
    ({"cycle": Cycle.FAULT}, GrantKind.IDLE, 0, False),
]


@pytest.mark.parametrize(("state", "kind", "tidies_s", "soon"), SOON)
def test_who_joins_drives_soon_where_nobody_waits_and_the_robot_leaves_what_it_does(
    robots, people, monkeypatch, state, kind, tidies_s, soon
):
    robot = robots[0]
    monkeypatch.setattr(Robot, "tidying_s", lambda _: tidies_s)
    Robot.objects.update(**state)
    if kind:
        until = SYSTEM.now() + timedelta(minutes=1)
        Grant.objects.create(robot=robot, kind=kind, epoch=1, opened_at=SYSTEM.now(), until=until)

    def told():
        return snapshot(robot.slug, AnonymousUser(), SYSTEM.now(), True)["robot"]["soon"]

    assert told() is soon
    queue.join(robot, people["ada"], SYSTEM.now())
    assert not told(), "somebody waits"


def test_more_robots_and_pictures_cost_few_queries(robots, people, client, django_assert_max_num_queries):
    ended(robots[0], people["ada"], pictures=30)
    client.get("/")
    for most in (75, 75 + 4 * 14):
        with django_assert_max_num_queries(most):
            client.get("/")
        Robot.objects.bulk_create(
            Robot(slug=f"r{most}-{n}", name=f"R {n}", driver=robots[0].driver, address=f"sim:{n}", enabled=True)
            for n in range(4)
        )


def test_without_a_robot_the_page_says_so(client, db):
    assert "No robot is switched on yet" in client.get("/").content.decode()


def test_a_free_robot_says_so_and_each_person_who_waits_makes_the_wait_longer(robots, people, client):
    robot = robots[0]
    assert "Free now" in client.get("/").content.decode()
    drive(robot, people["ada"], SYSTEM.now())
    first = wait_if_joined(robot, SYSTEM.now())
    queue.join(robot, people["bob"], SYSTEM.now())
    assert wait_if_joined(robot, SYSTEM.now()) > first
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.FAULT)
    robot.refresh_from_db()
    assert wait_if_joined(robot, SYSTEM.now()) is None


def test_the_button_leads_each_person_to_their_next_step(robots, people, client):
    address = "/robots/mercury/drive/"
    assert client.get(address)["Location"] == "/accounts/signup/?next=%2Frobots%2Fmercury%2Fdrive%2F"
    client.force_login(people["eve"])
    assert client.get(address)["Location"] == "/robots/mercury/orientation/"
    services.mark_read(people["eve"], robots[0], SYSTEM.now())
    assert client.get(address)["Location"] == "/robots/mercury/clearance/"
    client.force_login(people["ada"])
    assert client.get(address)["Location"] == "/robots/mercury/"
    assert client.get("/robots/none/drive/").status_code == 404


def test_the_button_leads_who_drives_back_to_their_robot(robots, people, client):
    people["ada"].clearances.create(robot=robots[1], granted_at=SYSTEM.now())
    client.force_login(people["ada"])
    before = client.get("/").content.decode()
    drive(robots[1], people["ada"], SYSTEM.now())
    during = client.get("/").content.decode().partition('class="hero"')[2]
    assert ">Drive Mercury" in before and ">Drive " not in during
    assert '<a class="button primary" href="/robots/other/">Back to Other</a>' in during


def test_the_snapshot_tells_the_wait_of_somebody_who_joins(robots, people):
    told = snapshot("mercury", people["eve"], SYSTEM.now(), True)
    assert told["join_wait_s"] == wait_if_joined(robots[0], SYSTEM.now())


def written(turn, frame):
    return Entry.objects.create(
        turn=turn, author=turn.user, robot=turn.robot, text="Only sand", written_at=SYSTEM.now(), frame=frame
    )


def test_a_confirmed_find_is_the_newest_find_and_an_entry_is_not(robots, people, client):
    robot, now = robots[0], SYSTEM.now()
    turn = ended(robot, people["ada"])
    first, second, last = Frame.objects.filter(grant=turn.grant)
    entry = written(turn, last)
    text = client.get("/").content.decode()
    assert "Newest in the log" in text
    assert "Newest find" not in text
    hidden = Round.objects.create(robot=robot, number=1, began_at=now - timedelta(days=1))
    piece = Piece.objects.create(round=hidden, name="thimble")
    made = [
        Find.objects.create(round=hidden, turn=turn, author=people["ada"], name=name, x=0.1, y=0.4, frame=frame,
                            seen_at=now + timedelta(seconds=n), reported_at=now)
        for n, (name, frame) in enumerate((("one", first), ("two", second), ("none", None), ("reported", second)))
    ]  # fmt: skip
    assert "Newest find" not in client.get("/").content.decode(), "no moderator has decided"
    Find.objects.filter(pk__in=[one.pk for one in made[:3]]).update(state="confirmed", piece=piece)
    answer = client.get("/")
    assert answer.context["find"] == made[1]
    text = re.sub(r"\s+", " ", answer.content.decode())
    assert "Newest in the log" not in text
    shown_find = re.search(r'<a class="card find".*?</a>', text)[0]
    for said in ("Newest find", second.url, "ada on Mercury", "thimble, at x 10 cm, y 40 cm"):
        assert said in shown_find
    assert answer.context["entries"] == [entry], "it stands in the log below"
    Entry.objects.update(visibility="hidden")
    assert shown(client)["find"] is None, "its pictures are hidden"


@pytest.fixture
def twins(robots):
    """Simulators of both robots, ready and free."""
    made = []
    for robot in robots:
        twin = robot_services.twin_of(robot)
        Lease.objects.create(robot=twin, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
        queue.queue_of(twin)
        made.append(twin)
    Robot.objects.update(cycle=Cycle.READY)
    return made


def test_the_simulator_is_that_of_the_robot_that_leads_and_is_named(robots, twins, people, client):
    other = robots[1]
    people["ada"].clearances.create(robot=other, granted_at=SYSTEM.now())
    ended(other, people["ada"])
    drive(twins[1], people["bob"], SYSTEM.now())
    answer = client.get("/")
    assert (answer.context["drive"], answer.context["practice"]) == (other, twins[1])
    assert "Try a simulator of Other first" in answer.content.decode()


def test_else_it_is_one_that_is_free_and_none_if_none_is_online(robots, twins, people, client):
    third = Robot.objects.create(
        slug="third", name="Third", driver=robots[0].driver, address="sim:third", enabled=True, cycle=Cycle.READY
    )
    Lease.objects.create(robot=third, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
    people["ada"].clearances.create(robot=third, granted_at=SYSTEM.now())
    queue.queue_of(third)
    ended(third, people["ada"])
    drive(twins[0], people["bob"], SYSTEM.now())
    found = shown(client)
    assert (found["drive"], found["practice"]) == (third, twins[1])
    Lease.objects.filter(robot=twins[1]).update(expires_at=None)
    assert shown(client)["practice"] == twins[0], "one can wait for it"
    Lease.objects.filter(robot=twins[0]).update(expires_at=None)
    assert "Try a simulator" not in client.get("/").content.decode()
