"""A request is judged from the robot's present place, as its page and the robot do, not from its home."""

from datetime import timedelta

import pytest

from queueing.models import Job, QueueRobot
from queueing.services import Asker, ask
from robots import services
from robots.kit.contract.errors import BadRequest, OutOfWorkspace
from robots.models import Command, Grant, Lease
from robots.states import CommandState, Cycle, GrantKind
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db]
AWAY = (10.6, 6.45, 0.0)  # the node North-east, far from its home at the Door
LONG = "patrol 120\n" * 7 + "wait 48\ngo "
TO_HOME, TO_HERE = {"text": LONG + "Door"}, {"text": LONG + "North-east"}
LATE = "Step 9 cannot be done in time"


@pytest.fixture
def which(request):
    return getattr(request, "param", "srv1")


@pytest.fixture
def rover(robot, people, clock):
    """A rover of which people ask, and whose turn ada may have; it was heard a second ago, far from its home."""
    now = clock.now()
    Lease.objects.create(robot=robot, epoch=5, expires_at=now + timedelta(days=9))
    QueueRobot.objects.filter(robot=robot).update(guests_ask=True)
    heard(clock, 1)
    return robot


def heard(clock, ago_s, pose=AWAY, **more):
    """Store a state of that age, as the owner does."""
    told = {"joints": [], "pose": list(pose), "moving": False, "ready": True, "values": {"battery": 8.0}, **more}
    Lease.objects.update(state=told, state_at=clock.now() - timedelta(seconds=ago_s))


def asks(robot, people, clock, args, kind="mission"):
    return ask(robot, Asker(user=people["ada"]), kind, args, clock.now())


def test_a_job_that_cannot_be_done_from_here_is_refused_before_it_waits(rover, people, clock):
    with pytest.raises(OutOfWorkspace, match=LATE):
        asks(rover, people, clock, TO_HOME)
    assert not Job.objects.exists()
    assert asks(rover, people, clock, TO_HERE).state == "waiting", "from its home it could not be done"


@pytest.mark.parametrize("unknown", [{"ago_s": 61}, {"ago_s": 1, "pose": ()}, {"ago_s": 1, "joints": [0.5]}])
def test_where_nobody_knows_where_it_is_it_is_judged_from_home(rover, people, clock, unknown):
    heard(clock, **unknown)
    asks(rover, people, clock, TO_HOME)
    with pytest.raises(OutOfWorkspace, match=LATE):
        asks(rover, people, clock, TO_HERE)


@pytest.fixture
def turn(rover, people, clock):
    rover.cycle = Cycle.OPERATING
    rover.save()
    made = services.start_grant(rover, GrantKind.TURN, clock.now(), people["ada"], clock.now() + timedelta(hours=1))
    clock.go(5)
    heard(clock, 1)
    return made


def issued(robot, people, clock, kind, args):
    seq = services.next_seq(Grant.objects.get(ended_at=None))
    return services.issue(robot.slug, people["ada"], kind, args, seq, clock.now()).command


def test_a_command_of_a_turn_is_judged_from_here_too(rover, people, clock, turn):
    with pytest.raises(OutOfWorkspace, match=LATE):
        issued(rover, people, clock, "mission", TO_HOME)
    assert issued(rover, people, clock, "mission", TO_HERE).state == "queued"


def test_while_it_moves_and_until_it_was_heard_again_nobody_knows_from_where_it_will_begin(rover, people, clock, turn):
    first = issued(rover, people, clock, "turn", {"angle": 0.1})
    heard(clock, 0, moving=True)
    assert issued(rover, people, clock, "mission", TO_HOME).state == "queued"
    for command in Command.objects.select_related("robot", "grant").order_by("id"):
        rows.finish(command, CommandState.COMPLETED, clock.go(1))
    assert first.pk != issued(rover, people, clock, "mission", TO_HOME).pk, "it was heard before the motion ended"
    for command in Command.objects.select_related("robot", "grant").filter(ended_at=None):
        rows.finish(command, CommandState.COMPLETED, clock.go(1))
    clock.go(5)
    heard(clock, 1)
    with pytest.raises(OutOfWorkspace, match=LATE):
        issued(rover, people, clock, "mission", TO_HOME)


@pytest.mark.parametrize("which", ["mercury"], indirect=True)
def test_what_was_true_before_a_command_refuses_none_after_it(robot, people, clock):
    Lease.objects.create(robot=robot, epoch=5, expires_at=clock.now() + timedelta(days=9))
    up = {"joints": [0.0] * len(robot.spec().joints), "pose": [0.0, 0.3, 0.05, 0.0]}
    services.start_grant(robot, GrantKind.TURN, clock.now(), people["ada"], clock.now() + timedelta(hours=1))
    clock.go(5)
    heard(clock, 0, **up)
    with pytest.raises(BadRequest, match="press Down first"):
        issued(robot, people, clock, "air", {})
    issued(robot, people, clock, "down", {})
    assert issued(robot, people, clock, "air", {}).state == "queued", "it will be down by then"
