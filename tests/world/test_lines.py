"""Each robot in virtual time: handover, a motion, a lost line, a lost owner; and a run that comes back."""

from robots.models import Frame, Grant
from robots.states import GrantKind
from tests.world.portal import EACH
from tests.world.seeds import hunt, seeds

pytestmark = EACH


def begun_and_at_rest(portal, within_s):
    """Return how many motions had begun before the robot came to rest, and none after it."""
    portal.at_rest(within_s)
    begun = len(portal.motions())
    portal.world.sleep(5)
    assert not portal.rig.moving
    assert len(portal.motions()) == begun, "something moved without an owner, or after it came back"
    return begun


def a_move(portal):
    portal.ready()
    handover = Grant.objects.get(kind=GrantKind.HANDOVER)
    assert Frame.objects.filter(grant=handover).exists(), "a robot was offered without a picture"
    assert portal.rig.count("connected") <= 1
    portal.grant()
    begun = len(portal.motions())
    command = portal.final(portal.move(0))
    assert command.state == "completed", command.reason
    (motion,) = portal.motions()[begun:]
    assert portal.wishes.made(motion) == portal.wishes.goal(command)
    assert not portal.rig.moving


@seeds(2, 10)
def test_a_robot_is_handed_over_and_moves_where_it_was_asked_to(worlds, seed):
    hunt(worlds, seed, a_move)


def lost_line(portal):
    portal.grant()
    command = portal.move(1)
    portal.in_motion()
    portal.rig.cable.pull()
    command = portal.final(command)
    assert command.state in ("failed", "unknown"), f"{command.state}: {command.reason}"
    begun_and_at_rest(portal, 10)
    portal.rig.cable.plug()
    portal.until(lambda: portal.row.cycle != "fault" and portal.owner.connected, 60, "the line again")
    begun_and_at_rest(portal, 20)
    again = portal.final(portal.move(2))
    assert again.state == "completed", again.reason


@seeds(2, 10)
def test_a_lost_line_is_opened_again_and_nothing_is_repeated(worlds, seed):
    hunt(worlds, seed, lost_line)
