"""A setting beside a motion, over the real wire with real processes: a package's robot, its worker killed under both."""

import pytest

from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Command, Robot
from robots.states import Cycle
from tests.conftest import wait_for
from tests.rig import worker

pytestmark = pytest.mark.timed


def state_of(command):
    command.refresh_from_db()
    return command.state


def test_a_setting_completes_beside_a_motion_and_a_crash_under_both_is_unknown(turntable, people):
    robot, children = turntable(TURNTABLE_TAKES_S="2")  # so that a new pace is seen on its way

    def issue(kind, seq, **args):
        return services.issue(robot.slug, people["ada"], kind, args, seq).command

    slow, far = issue("pace", 1, pace=0.3), issue("turn", 2, angle=3.0)
    wait_for(lambda: state_of(slow) == "completed", 10, "the pace")
    wait_for(lambda: state_of(far) == "acknowledged", 10, "it turns")
    other = issue("pace", 3, pace=0.2)
    wait_for(lambda: state_of(other) == "completed", 10, "the pace beside the motion")
    assert state_of(far) == "acknowledged"
    assert far.progress["text"].endswith(" rad")
    assert 0.0 < far.progress["share"] < 1.0
    last = issue("pace", 4, pace=0.4)
    wait_for(lambda: state_of(last) == "sent", 10, "both are on their way")
    children[-1].kill()
    assert (state_of(far), state_of(last)) == ("acknowledged", "sent")
    children.append(worker("turntable"))
    wait_for(lambda: state_of(far) == state_of(last) == "unknown", 30, "neither is known")

    services.end_grant(services.open_grant(robot), "holder", "test", SYSTEM.now())
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.HANDOVER)
    wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 60, "it is put in order")
    row = Command.objects.filter(robot=robot, kind="pace").first()
    assert (row.state, row.args, row.issued_by) == ("completed", {"pace": 1.0}, None)
