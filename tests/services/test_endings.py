"""Why a turn ended, what it costs and what its person can do next: the same on every page; and idleness."""

import ast
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from pathlib import Path
from threading import Event

import pytest
from django.conf import settings
from django.db import OperationalError, connection, transaction
from django.test import Client

from portal.live import actions
from portal.live.messages import Release, Stop
from portal.live.snapshot import snapshot
from portal.live.standing import act, place_info
from queueing import services as queue
from queueing.models import PlaceEnd, Queue, Ticket, TicketState, Turn
from queueing.services import Place, end_by_staff, end_session, idle_at, note_act, remove_by_staff, standings, stay
from queueing.words import PLACE_ENDS, TURN_ENDS
from robots import services
from robots.models import Command, Lease, Robot
from robots.states import CommandState, GrantEnd, Lane
from tests.environment import ON_POSTGRES
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]
RULES = settings.FARHAND
IDLE_S = RULES["IDLE_S"]


@pytest.fixture
def driven(robot, people, clock):
    """Ada drives, and Bob waits from the beginning."""
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": clock.now() + timedelta(days=99)})
    turn = drive(robot, people["ada"], clock.now())
    queue.join(robot, people["bob"], clock.now())
    return turn


def tick(robot, people, clock, seconds):
    """Both pages are open meanwhile."""
    clock.go(seconds)
    for name in ("ada", "bob"):
        queue.note_presence(robot, people[name], clock.now())
    queue.tick(clock.now())


def end(turn):
    turn.refresh_from_db()
    turn.grant.refresh_from_db()
    return turn.grant.end_code


def command(turn, clock, **more):
    return Command.objects.create(
        robot=turn.robot, grant=turn.grant, issued_by=turn.user, client_seq=Command.objects.count() + 1, kind="up",
        epoch=1, created_at=clock.now(), deadline=clock.now() + timedelta(seconds=60), **more,
    )  # fmt: skip


def test_every_kind_of_end_has_its_words():
    assert set(TURN_ENDS) == set(GrantEnd)
    assert set(PLACE_ENDS) == set(PlaceEnd)
    for words in (*TURN_ENDS.values(), *PLACE_ENDS.values()):
        assert all(text.endswith(".") and text[0].isupper() for text in (words.why, words.credited, words.next))


def test_no_place_and_no_turn_is_ended_for_a_reason_beside_the_tables():
    """Whoever withdraws a place names a `PlaceEnd`, whoever ends a turn or a grant names a `GrantEnd`."""
    root, found = Path(__file__).resolve().parents[2], []
    for room in ("queueing", "portal", "robots", "workers", "operatorlog", "accounts"):
        for path in (root / room).rglob("*.py"):
            for call in ast.walk(ast.parse(path.read_text())):
                name = getattr(getattr(call, "func", None), "attr", getattr(getattr(call, "func", None), "id", ""))
                at = {"withdraw": 3, "end_turn": 1, "end_grant": 1}.get(name)
                if isinstance(call, ast.Call) and at is not None:
                    found.append((name, ast.unparse(call.args[at])))
    words = {text for _, text in found}
    assert {"PlaceEnd.AWAY", "GrantEnd.IDLE"} <= words
    named = [text for text in words if not text.startswith(("PlaceEnd.", "GrantEnd"))]
    assert sorted(named) == ["code", "reason"], "what is passed on, and typed"


def test_idleness_is_foreseen_and_ends_the_turn_when_it_was_said(driven, robot, people, clock):
    foreseen = idle_at(driven, clock.now())
    assert foreseen == clock.now() + timedelta(seconds=IDLE_S)
    [shown] = standings(people["ada"], clock.now())
    assert place_info(shown, clock.now())["idle_ms"] == foreseen.timestamp() * 1000
    tick(robot, people, clock, IDLE_S)
    assert end(driven) == ""
    tick(robot, people, clock, 1)
    assert end(driven) == GrantEnd.IDLE


def test_nothing_is_foreseen_while_nobody_waits_or_where_the_time_is_up_before(driven, robot, people, clock):
    Turn.objects.update(until=clock.now() + timedelta(seconds=IDLE_S - 1))
    driven.refresh_from_db()
    assert idle_at(driven, clock.now()) is None
    Turn.objects.update(until=clock.now() + timedelta(seconds=IDLE_S + 1))
    driven.refresh_from_db()
    assert idle_at(driven, clock.now()) is not None
    queue.leave(robot, people["bob"], clock.now())
    assert idle_at(driven, clock.now()) is None


@pytest.mark.parametrize("what", ["says so", "stops", "commands"])
def test_whoever_does_something_or_says_that_they_are_here_stays(driven, robot, people, clock, what):
    tick(robot, people, clock, IDLE_S - 1)
    if what == "says so":
        assert act(people["ada"], "stay", robot.slug, 0, clock.now()) == ""
    elif what == "stops":
        services.stop(robot, people["ada"], clock.now())
        note_act(robot, people["ada"], clock.now())
    else:
        command(driven, clock, state=CommandState.COMPLETED, ended_at=clock.now())
    tick(robot, people, clock, IDLE_S)
    assert end(driven) == ""
    tick(robot, people, clock, 1)
    assert end(driven) == GrantEnd.IDLE


def test_whoever_is_waiting_for_their_own_command_does_something(driven, robot, people, clock):
    running = command(driven, clock, state=CommandState.ACKNOWLEDGED)
    tick(robot, people, clock, IDLE_S + 1)
    assert end(driven) == ""
    Command.objects.filter(pk=running.pk).update(state=CommandState.COMPLETED, ended_at=clock.now())
    tick(robot, people, clock, IDLE_S + 1)
    assert end(driven) == GrantEnd.IDLE


@pytest.mark.parametrize("name", ["stop", "release"])
@pytest.mark.parametrize("busy", ["queueing.turns.lock", "queueing.turns.Turn.objects.select_for_update"])
def test_a_stop_is_answered_though_it_cannot_be_noted(driven, robot, people, monkeypatch, name, busy):
    message = Stop() if name == "stop" else Release(checked=True)

    def away(*_, **__):
        raise OperationalError("locked")

    monkeypatch.setattr("portal.live.actions.current_user", lambda scope: people["ada"])
    monkeypatch.setattr(busy, away)
    assert actions.act({}, robot.slug, message).ok
    client = Client()
    client.force_login(people["ada"])
    address = client.get(f"/classic/{robot.slug}/").url
    assert client.post(address, {"do": name, "checked": "yes"}).status_code == 302
    robot.refresh_from_db()
    assert robot.stop_latched is (name == "stop")


@pytest.mark.django_db(transaction=True)
@pytest.mark.skipif(not ON_POSTGRES, reason="one row is not locked by itself")
@pytest.mark.parametrize("rows", [Queue, Turn])
def test_a_stop_waits_for_no_tick(driven, robot, people, clock, rows):
    held, done = Event(), Event()

    def tick():
        with transaction.atomic():
            list(rows.objects.select_for_update())
            held.set()
            done.wait(20)
        connection.close()

    with ThreadPoolExecutor() as pool:
        ticking = pool.submit(tick)
        held.wait(10)
        services.stop(robot, people["ada"], clock.now())
        note_act(robot, people["ada"], clock.go(1))
        held_still = not ticking.done()
        done.set()
        ticking.result()
    assert held_still
    driven.refresh_from_db()
    assert (driven.acted_at is None) is (rows is Turn)


def test_a_setting_given_in_mid_motion_hides_no_motion(driven, robot, people, clock):
    running = command(driven, clock, state=CommandState.ACKNOWLEDGED)
    command(driven, clock, state=CommandState.COMPLETED, ended_at=clock.now(), lane=Lane.CONFIG)
    tick(robot, people, clock, IDLE_S + 1)
    assert end(driven) == ""
    Command.objects.filter(pk=running.pk).update(state=CommandState.COMPLETED, ended_at=clock.now())
    tick(robot, people, clock, IDLE_S)
    assert end(driven) == "", "counted from the end of the motion"


@pytest.mark.parametrize("by", ["kim", None])
@pytest.mark.parametrize("ended", [True, False])
def test_what_others_set_meanwhile_is_no_act_of_the_operator(driven, robot, people, clock, by, ended):
    clock.go(IDLE_S - 10)
    state = {"state": CommandState.COMPLETED, "ended_at": clock.now()} if ended else {"state": CommandState.SENT}
    row = command(driven, clock, lane=Lane.CONFIG, **state)
    Command.objects.filter(pk=row.pk).update(issued_by=people.get(by))
    tick(robot, people, clock, 11)
    assert end(driven) == GrantEnd.IDLE


def test_only_the_operator_can_say_that_they_are_here(driven, robot, people, clock):
    assert not stay(robot, people["bob"], clock.now())
    assert act(people["bob"], "stay", robot.slug, 0, clock.now()) == "Your turn on this robot is over."
    queue.leave(robot, people["ada"], clock.now())
    assert act(people["ada"], "stay", robot.slug, 0, clock.now()) == "Your turn on this robot is over."


ENDED = {
    GrantEnd.HOLDER: lambda turn, kim, now: queue.leave(turn.robot, turn.user, now),
    GrantEnd.STAFF: lambda turn, kim, now: end_by_staff(turn, kim, now),
    GrantEnd.LOCKED_OUT: lambda turn, kim, now: services.lock_out(turn.robot, kim, "A leaf."),
    GrantEnd.SWITCHED_OFF: lambda turn, kim, now: services.set_enabled(turn.robot, kim, False),
    GrantEnd.SIGNED_OUT: lambda turn, kim, now: end_session(
        turn.robot.slug, turn.user_id, Place.TURN_ENDS, "signed out", now
    ),
    GrantEnd.UNFIT: lambda turn, kim, now: turn.user.clearances.update(revoked_at=now),
    GrantEnd.ABSENT: lambda turn, kim, now: queue.note_disconnection(
        turn.robot, turn.user, now - timedelta(seconds=RULES["RECONNECT_S"] + 1)
    ),
    GrantEnd.SILENT: lambda turn, kim, now: Turn.objects.update(
        classic=True, last_seen=now - timedelta(seconds=RULES["CLASSIC_PRESENCE_S"] + 1)
    ),
    GrantEnd.IDLE: lambda turn, kim, now: (
        Turn.objects.update(started_at=now - timedelta(seconds=IDLE_S + 1))
        + Ticket.objects.update(joined_at=now - timedelta(seconds=IDLE_S + 1))
    ),
    GrantEnd.TIME_UP: lambda turn, kim, now: Turn.objects.update(until=now),
}


@pytest.mark.parametrize("code", ENDED, ids=[str(code) for code in ENDED])
def test_after_every_end_each_page_says_why_what_it_costs_and_what_is_next(driven, robot, people, clock, code):
    ada = people["ada"]
    clock.go(30)
    queue.note_presence(robot, ada, clock.now())
    queue.note_presence(robot, people["bob"], clock.now())
    ENDED[code](driven, people["kim"], clock.now())
    queue.tick(clock.now())
    assert end(driven) == code
    words = TURN_ENDS[code]
    told = snapshot(robot.slug, ada, clock.now(), True)["me"]["last_end"]
    assert told["why"].split("{")[0].startswith(words.why.split("{")[0])
    assert "{" not in told["why"] + told["credited"] + told["next"]
    used = f"{round(driven.charged_s)} s" if driven.charged_s < 60 else "min"
    assert used in told["credited"], "what was really charged"
    assert told["own"] is (code == GrantEnd.HOLDER)
    places = [place_info(one, clock.now()) for one in standings(ada, clock.now())]
    if code == GrantEnd.HOLDER:
        assert places == [], "whoever ended it knows"
    else:
        assert [(one["state"], one["end"]["why"], one["turn"]) for one in places] == [("ended", told["why"], driven.pk)]
    client = Client()
    client.force_login(ada)
    page = client.get(driven.get_absolute_url()).content.decode()
    assert f"UTC: {driven.end_reason}" not in page, "the page says once why"
    for text in (told["why"], told["credited"], told["next"]):
        assert text.replace("'", "&#x27;") in page
    assert told["why"].replace("'", "&#x27;") in client.get("/me/").content.decode()
    assert told["credited"] not in Client().get(driven.get_absolute_url()).content.decode(), "it is theirs"


def test_an_end_is_told_for_an_hour_or_until_it_is_dismissed(driven, robot, people, clock):
    end_by_staff(driven, people["kim"], clock.now())
    [one] = standings(people["ada"], clock.now())
    assert act(people["bob"], "dismiss", "", one.ticket, clock.now()) == ""
    assert [s.state for s in standings(people["ada"], clock.go(3599))] == ["ended"], "another person dismisses nothing"
    assert standings(people["ada"], clock.go(2)) == []
    clock.go(-10)
    assert act(people["ada"], "dismiss", "", one.ticket, clock.now()) == ""
    assert standings(people["ada"], clock.now()) == []


def test_whoever_is_taken_out_of_the_queue_is_told(driven, robot, people, clock):
    ticket = queue.open_ticket(robot, people["bob"])
    remove_by_staff(ticket, people["kim"], clock.now())
    [one] = standings(people["bob"], clock.now())
    assert (one.state, one.end, one.turn) == ("ended", PLACE_ENDS[PlaceEnd.REMOVED], None)
    ticket.refresh_from_db()
    assert ticket.state == TicketState.LEFT
    queue.join(robot, people["bob"], clock.now())
    queue.leave(robot, people["bob"], clock.now())
    assert standings(people["bob"], clock.now()) == [], "whoever leaves knows"


def test_the_wait_is_not_known_while_staff_have_paused_the_queue(driven, robot, people, clock):
    assert standings(people["bob"], clock.now())[0].wait_s is not None
    Queue.objects.update(paused=True)
    assert standings(people["bob"], clock.now())[0].wait_s is None
    assert end(driven) == "", "a turn goes on"


def test_a_turn_that_somebody_waits_for_is_not_said_to_go_on(driven, robot, people, clock):
    shown = snapshot(robot.slug, people["ada"], clock.now(), True)
    assert shown["turn"]["wanted"]
    queue.leave(robot, people["bob"], clock.now())
    assert not snapshot(robot.slug, people["ada"], clock.now(), True)["turn"]["wanted"]
    assert Robot.objects.get().enabled
