"""The permit by which the rover goes on alone, what ends it, and what its journal tells of the time without contact."""

import pytest

from robots.kit.drivers.srv1 import protocol
from robots.kit.drivers.srv1.answers import Acknowledgement, Event, Reason, Refusal
from robots.kit.drivers.srv1.extension import HOLD, Ask, Claim, Journal, Patrol, Permit, encode
from tests.drivers.srv1_wire import Rig
from tests.drivers.test_srv1_commander import HALL, drive, events, parse, patrol, permit, stamp

pytestmark = pytest.mark.django_db(transaction=True)


@pytest.fixture
def rig():
    made = Rig(parse=parse)
    yield made
    made.close()


def test_a_permit_lets_it_go_on_alone_until_its_end(rig):
    rig.ask(Claim(7))
    assert rig.ask(permit(rig, 61.0)) == Refusal("p", Reason.BOUNDS), "longer than it takes"
    assert rig.ask(permit(rig, 5.0, epoch=6)) == Refusal("p", Reason.EPOCH)
    assert isinstance(rig.ask(permit(rig, 5.0)), Acknowledgement)
    rig.ask(Patrol(7, stamp(rig)))
    rig.pass_s(4.0)
    status = rig.ask(Ask())
    assert status.mode == "patrol"
    assert status.linear == pytest.approx(0.2, abs=0.03), "not faster than permitted"
    assert 0 < status.permit_ms < 1000
    assert rig.rest() == "permit"
    assert rig.ask(Ask()).permit_ms == 0
    assert Event.EXPIRED in events(rig)


def test_at_the_end_of_a_permit_an_owner_that_is_heard_is_not_stopped(rig):
    rig.ask(Claim(7))
    rig.ask(permit(rig, 1.0))
    patrol(rig, 3.0)
    assert rig.bench.drive.moving
    assert rig.count("motion") == 1


@pytest.mark.parametrize(
    ("area", "speed", "event"), [((0.0, 0.0, 1.5, 8.0), 0.4, Event.LEFT), (HALL, 0.05, Event.FAST)]
)
def test_a_permit_ends_outside_its_area_and_above_its_speed(rig, area, speed, event):
    rig.ask(Claim(7))
    drive(rig, 1.0, 0.3)
    rig.ask(permit(rig, 20.0, speed, area))
    if event is Event.LEFT:
        rig.ask(Patrol(7, stamp(rig)))
        rig.pass_s(4.0)
        assert 1.5 < rig.bench.x < 1.6
    assert rig.rest() == "permit"
    assert event in events(rig)
    assert rig.ask(Ask()).end == "permit"


@pytest.mark.parametrize("ends", ["hold", "claim", "letters"])
def test_what_ends_a_permit_before_its_time(rig, ends):
    rig.ask(Claim(7))
    rig.ask(permit(rig, 20.0))
    rig.ask(Patrol(7, stamp(rig)))
    rig.pass_s(1.0)
    rig.say({"hold": HOLD, "claim": encode(Claim(8)), "letters": protocol.motion(1, 1, 0.01)}[ends])
    assert rig.rest() == {"hold": "held", "claim": "replaced", "letters": "done"}[ends]
    assert rig.ask(Ask()).permit_ms == 0


def test_a_permit_that_comes_late_ends_no_later(rig):
    rig.ask(Claim(7))
    wanted = permit(rig, 2.0)
    rig.pass_s(1.5)
    rig.ask(wanted)
    assert rig.ask(Ask()).permit_ms <= 500
    rig.pass_s(1.0)
    assert isinstance(rig.ask(wanted), Acknowledgement), "its end is past"
    assert rig.ask(Ask()).permit_ms == 0


def test_a_patrol_that_comes_late_moves_nothing(rig):
    rig.ask(Claim(7))
    rig.ask(permit(rig, 20.0))
    late = Patrol(7, stamp(rig))
    rig.pass_s(0.6)
    assert rig.ask(late) == Refusal("g", Reason.LATE)
    assert not rig.bench.drive.moving


def test_renewing_a_permit_is_written_once(rig):
    rig.ask(Claim(7))
    for _ in range(3):
        rig.ask(permit(rig, 5.0))
    rig.ask(Permit(7, 0, 0.2, HALL))
    assert events(rig).count(Event.PERMIT) == 2


def test_the_same_owner_comes_back_during_its_permit(rig):
    rig.ask(Claim(7))
    rig.ask(permit(rig, 20.0))
    rig.ask(Patrol(7, stamp(rig)))
    rig.pass_s(3.0)
    assert rig.ask(Claim(7)).mode == "patrol"
    assert rig.count("motion") == 1


def test_its_journal_tells_the_way_that_it_drove_without_a_word(rig):
    rig.ask(Claim(7))
    rig.ask(permit(rig, 6.0))
    patrol(rig, 1.0)
    rig.pass_s(8.0)
    found, since = [], 0
    while entries := rig.ask(Journal(since)).entries:
        found += entries
        since = entries[-1].number
    names = [entry.event for entry in found]
    begun = found[names.index(Event.ALONE)]
    way = [entry for entry in found if entry.event is Event.WAY]
    assert way
    assert all(b.x - a.x >= 0.45 for a, b in zip([begun, *way], way, strict=False))
    assert names.index(Event.EXPIRED) > names.index(Event.WAY)
    assert found[-1].event is Event.REST
    assert found[-1].x == pytest.approx(rig.bench.x, abs=0.05)
    assert Event.HEARD not in names


def test_a_word_in_time_ends_the_way_without_one(rig):
    rig.ask(Claim(7))
    rig.ask(permit(rig, 6.0))
    patrol(rig, 0.5)
    rig.pass_s(2.0)
    patrol(rig, 0.5)
    told = events(rig)
    assert told.index(Event.ALONE) < told.index(Event.HEARD)
