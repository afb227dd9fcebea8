"""Each robot in virtual time: handover, a motion, a lost line, a lost owner; and a run that comes back."""

import random

from robots.models import Command, Frame, Grant
from robots.states import GrantKind
from tests.world.delays import Delays
from tests.world.motions import Motions
from tests.world.portal import EACH
from tests.world.seeds import hunts

pytestmark = EACH


def in_mid_motion(portal):
    """Begin a motion and let it go on for a moment; return its command."""
    command = portal.move()
    portal.in_motion()
    portal.world.sleep(0.3 * random.Random(portal.world.seed).random())
    assert portal.rig.moving
    return command


@hunts(1, 10, 100)
def test_a_robot_is_handed_over_and_moves_where_it_was_asked_to(portal):
    portal.ready()
    handover = Grant.objects.get(kind=GrantKind.HANDOVER)
    assert Frame.objects.filter(grant=handover).exists(), "a robot was offered without a picture"
    portal.grant()
    begun = len(portal.motions())
    command = portal.final(portal.move())
    assert command.state == "completed", command.reason
    (motion,) = portal.motions()[begun:]
    assert portal.wishes.made(motion) == portal.wishes.goal(command)
    assert not portal.rig.moving


@hunts(1, 20, 200)
def test_a_lost_line_is_opened_again_and_no_motion_is_repeated(portal):
    history = Motions(portal)
    portal.grant()
    command = in_mid_motion(portal)
    portal.rig.pull()
    command = portal.final(command)
    assert command.state in ("failed", "unknown"), f"{command.state}: {command.reason}"
    portal.at_rest()
    portal.world.sleep(5)
    assert not portal.rig.moving
    portal.rig.plug()
    portal.works_on()
    history.check()


def test_a_run_depends_on_its_seed_alone(worlds):
    def run(seed):
        portal = worlds(seed, Delays(seed, share=0.01, mean_s=0.1, longest_s=1.0))
        portal.grant()
        in_mid_motion(portal)
        portal.stop()
        portal.all_final()
        portal.release()
        portal.supervisor.worker.kill()
        portal.works_on()
        states = list(Command.objects.order_by("pk").values_list("state", flat=True))
        return portal.world.history, states, portal.rig.journal()

    first, again, other = run(1), run(1), run(2)
    assert first == again
    assert first[0] != other[0]
