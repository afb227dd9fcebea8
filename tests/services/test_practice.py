"""Practice on a simulator: guests without an account, what they may not do, and people who wait for the robot."""

from datetime import timedelta

import pytest
from django.contrib.auth import get_user_model
from django.core.exceptions import ValidationError
from django.db import IntegrityError, transaction

from accounts import guests
from accounts.services import cleared
from operatorlog import services as log
from operatorlog.finds import Report, report
from operatorlog.models import Find
from portal.live import actions
from portal.live.messages import Join
from portal.live.people import current_user
from portal.live.snapshot import snapshot
from portal.web.daily.figures import numbers_of
from queueing import services as queue
from queueing.errors import NotCleared
from queueing.jobs.kinds import may_ask
from queueing.models import Ticket, Turn
from robots import services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, NotPermitted
from robots.models import Lease, Robot
from robots.services import programs
from robots.states import Cycle, GrantEnd
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]

PAGE, PRESS = "/robots/mercury-practice/", "/robots/mercury-practice/practise/"
User = get_user_model()


@pytest.fixture
def twin(robot):
    """The simulator for practice, ready beside the robot."""
    made = services.twin_of(robot)
    Robot.objects.update(cycle=Cycle.READY)
    for one in (robot, made):
        Lease.objects.update_or_create(robot=one, defaults={"epoch": 1, "expires_at": SYSTEM.now() + timedelta(days=9)})
    made.refresh_from_db()
    robot.refresh_from_db()
    return made


@pytest.fixture
def guest(twin, client):
    """Somebody without an account, who has pressed "Try it"."""
    assert client.post(PRESS)["Location"] == PAGE
    return User.objects.get(guest=True)


def practise(twin, person, now):
    queue.queue_of(twin)
    return drive(twin, person, now)


def scope_of(client, slug=None):
    key = {"sessionid": client.session.session_key}
    return {"cookies": key, **({"url_route": {"kwargs": {"slug": slug}}} if slug else {})}


def test_a_guest_takes_control_as_soon_as_the_page_is_open_for_as_long_as_the_robot_says(twin, guest, client):
    assert " data-take" in client.get(PAGE).content.decode()
    turn = practise(twin, guest, now := SYSTEM.now())
    assert (turn.until - turn.started_at).total_seconds() == twin.guest_s == 60
    assert snapshot(twin.slug, guest, now, True)["me"]["guest"]
    queue.note_presence(twin, guest, now + timedelta(seconds=58))
    queue.tick(now + timedelta(seconds=58))
    queue.tick(now + timedelta(seconds=61))
    turn.refresh_from_db()
    assert turn.ended_at is not None, "though nobody waits"


def test_a_guest_is_signed_in_nowhere_else(twin, guest, robot, client):
    for address in ("/", "/log/", "/robots/mercury/", "/status/", "/accounts/signup/"):
        html = client.get(address).content.decode()
        assert guest.username not in html, address
        assert "Sign in" in html, address
    for address in ("/me/", "/accounts/email/", "/accounts/password/change/"):
        assert "/accounts/login/" in client.get(address)["Location"], address
    assert "/admin/login/" in client.get("/admin/")["Location"]
    assert "/accounts/signup/" in client.get("/robots/mercury/drive/")["Location"]
    assert current_user(scope_of(client, "mercury-practice")) == guest
    assert not current_user(scope_of(client, "mercury")).is_authenticated
    assert actions.act(scope_of(client, "mercury"), "mercury", Join()).code == "signed_out"


def test_a_guest_may_drive_no_robot_even_one_that_requires_no_clearance(twin, guest, robot):
    Robot.objects.filter(pk=robot.pk).update(clearance_required=False)
    robot.refresh_from_db()
    assert cleared(guest, twin)
    assert not cleared(guest, twin, 2)
    assert not cleared(guest, robot)
    with pytest.raises(NotCleared):
        queue.join(robot, guest, SYSTEM.now())
    Robot.objects.filter(pk=twin.pk).update(guest_s=None)
    twin.refresh_from_db()
    assert not cleared(guest, twin), "staff have ended practice without an account"


def test_a_guest_drives_and_no_more(twin, guest):
    every = list(twin.spec().commands)
    assert not any(may_ask(twin, guest, command, False) or may_ask(twin, guest, command, True) for command in every)
    with pytest.raises(NotPermitted, match="Sign up"):
        programs.save(twin, guest, "Mine", "down", True, SYSTEM.now())


def test_people_with_an_account_need_no_clearance_to_practise(twin, people):
    assert cleared(people["eve"], twin)
    assert not cleared(people["eve"], Robot.objects.get(slug="mercury"))


def test_the_limit_of_a_network_address(twin, client, settings):
    settings.RATE_LIMITS = {**settings.RATE_LIMITS, "practice": "2/m/ip"}
    for _ in range(2):
        assert type(client)().post(PRESS).status_code == 302
    refused = type(client)().post(PRESS)
    assert refused.status_code == 429
    assert "network address" in refused.content.decode()
    assert User.objects.filter(guest=True).count() == 2


def test_who_is_signed_in_stays_who_they_are(twin, people, client):
    client.force_login(people["ada"])
    client.post(PRESS)
    assert not User.objects.filter(guest=True).exists()
    assert " data-take" in client.get(PAGE).content.decode()


def test_without_guests_one_signs_up_and_a_robot_is_no_place_for_practice(twin, robot, client):
    Robot.objects.filter(pk=twin.pk).update(guest_s=None)
    assert client.post(PRESS)["Location"].startswith("/accounts/signup/?next=")
    assert client.post("/robots/mercury/practise/").status_code == 404
    assert client.get(PRESS).status_code == 405
    assert not User.objects.filter(guest=True).exists()


def test_who_practises_while_they_wait_is_offered_the_robot_and_goes_on_to_it(twin, robot, people):
    now = SYSTEM.now()
    practice = practise(twin, people["ada"], now)
    queue.join(robot, people["ada"], now)
    queue.tick(now + timedelta(seconds=1))
    assert Ticket.objects.get(queue=queue.queue_of(robot)).state == "offered"
    turn = queue.accept(robot, people["ada"], now + timedelta(seconds=2))
    practice.refresh_from_db()
    assert practice.ended_at is not None
    assert practice.grant.end_code == GrantEnd.HOLDER
    assert Turn.objects.filter(ended_at=None).get() == turn


def test_who_drives_a_robot_does_not_practise_meanwhile(twin, robot, people):
    now = SYSTEM.now()
    turn = drive(robot, people["ada"], now)
    queue.queue_of(twin)
    queue.join(twin, people["ada"], now)
    queue.tick(now + timedelta(seconds=1))
    assert Ticket.objects.get(queue=queue.queue_of(twin)).state == "waiting"
    turn.refresh_from_db()
    assert turn.ended_at is None


def test_practice_is_in_no_list_of_robots_and_in_no_log(twin, people, client):
    turn = practise(twin, people["ada"], now := SYSTEM.now())
    queue.leave(twin, people["ada"], now + timedelta(seconds=9))
    turn.refresh_from_db()
    with pytest.raises(log.LogError, match="practice"):
        log.write(turn, people["ada"], "What I found", None, now + timedelta(seconds=9))
    client.force_login(people["ada"])
    assert "not written" not in client.get("/log/").content.decode()
    with pytest.raises(log.LogError, match="nothing is hidden"):
        report(turn, people["ada"], Report("a spoon", x=0.1, y=0.4), now + timedelta(seconds=9))
    page = client.get(turn.get_absolute_url()).content.decode()
    assert 'name="find"' not in page
    client.post(turn.get_absolute_url(), {"find": "a spoon", "find_x": "10", "find_y": "40"})
    assert not Find.objects.exists()
    assert client.get(f"{PAGE}finds/").status_code == 404
    assert "/finds/" not in client.get(PAGE).content.decode()
    home = client.get("/").content.decode()
    assert 'data-live="mercury"' in home
    assert 'data-live="mercury-practice"' not in home
    assert "Try a simulator of Mercury first" in home
    assert snapshot(twin.slug, people["ada"], now, True)["me"]["last_turn"] is None
    figures = numbers_of(now.date())
    assert twin.pk not in figures
    assert figures[None]["turns"] == 0


def test_the_clearance_of_a_robot_is_not_asked_for_at_its_simulator(twin, client):
    assert client.get(f"{PAGE}orientation/").status_code == 404
    assert client.get(f"{PAGE}drive/")["Location"] == PAGE


def test_guests_of_yesterday_are_removed_with_their_names(twin, guest):
    practise(twin, guest, SYSTEM.now())
    queue.leave(twin, guest, SYSTEM.now())
    new = guests.new_guest(SYSTEM.now())
    User.objects.filter(pk=guest.pk).update(date_joined=SYSTEM.now() - timedelta(days=1, seconds=1))
    assert guests.remove_guests(SYSTEM.now()) == 1
    assert User.objects.get(guest=True) == new
    assert Turn.objects.get().user is None


def test_a_robot_for_practice_is_a_simulator_without_clearance(twin, robot):
    for wrong in ({"address": "tcp:arm:5000"}, {"clearance_required": True}, {"practice_for": None}):
        with pytest.raises(IntegrityError), transaction.atomic():
            Robot.objects.filter(pk=twin.pk).update(**wrong)
    robot.guest_s = 60
    with pytest.raises(ValidationError, match="only a robot for practice"):
        robot.full_clean()


def test_a_robot_has_one_twin_and_a_twin_has_none(twin, robot):
    assert services.twin_of(robot) == twin
    with pytest.raises(BadRequest, match="for practice itself"):
        services.twin_of(twin)
    robot.driver = "none"
    with pytest.raises(BadRequest, match="no simulator"):
        services.twin_of(robot)


def test_staff_add_the_simulator_from_the_list_of_robots(robot, roles, client):
    client.force_login(roles["superuser"])
    answer = client.post(
        "/admin/robots/robot/", {"action": "add_twins", "_selected_action": [robot.pk]}, follow=True
    )  # fmt: skip
    assert "/robots/mercury-practice/" in answer.content.decode()
    assert Robot.objects.get(practice_for=robot).name == "Mercury practice"
