"""The commands and scales that arms of `model.urdf` and `robot.toml` have in common, for their specs."""

from collections.abc import Iterable

from robots.kit.arms.chain import Chain
from robots.kit.arms.described import chain
from robots.kit.arms.follow import GRIP, HAND
from robots.kit.contract.channels import IN_SPACE, Scale
from robots.kit.contract.objects import Box
from robots.kit.contract.spec import Argument, CommandKind
from robots.kit.description import load

JOG_LONGEST_S, FOLLOW_LONGEST_S = 20.0, 120.0
FARTHEST_M, FARTHEST_RAD = 1.6, 7.0  # of a place that is asked for; the planner knows better
AHEAD, ASIDE, ABOVE = (  # where a place in the frame of the base is, as the page's own sentences say it
    ("ahead of the base", "behind the base"), ("to its left", "to its right"), ("above its foot", "below its foot"),
)  # fmt: skip
BEYOND = 0.02  # rad; an arm that was pushed further out is told in full states


def place_arguments(box: Box) -> tuple[Argument, ...]:
    """Return x, y and z of a place in a box in the frame of the base (m)."""
    ends = zip("xyz", box.low, box.size, (AHEAD, ASIDE, ABOVE), strict=True)
    return tuple(Argument(name, "m", low, low + size, label=ways[0], directions=ways) for name, low, size, ways in ends)


def arm_commands(driver: str, planned_s: float, replaceable: bool) -> dict[str, CommandKind]:
    """Return the commands by their kinds: `joints`, `pose`, `line`, `gripper`, jogs, `follow`, postures, `noop`.

    `planned_s`: how long the plan of a motion may take (s). `replaceable`: whether a newer target replaces a motion.
    """
    description, arm, place = load(driver), chain(driver), IN_SPACE.coordinates
    motion = description["motion"]
    limit = motion["limit_s"] + planned_s
    slowest, fastest = motion["scale_range"]
    share = Argument("speed", "", slowest, fastest, required=False, share="of full speed")
    joints = tuple(Argument(j.name, "rad", j.low, j.high) for j in arm.joints)
    there = (
        *place_arguments(Box((-FARTHEST_M,) * 3, (2 * FARTHEST_M,) * 3)),
        *(Argument(name, "rad", -FARTHEST_RAD, FARTHEST_RAD) for name in place[3:]),
    )
    jog = tuple(Argument(name, "", -1.0, 1.0, required=False) for name in arm.names)
    tool = tuple(Argument(name, "", -1.0, 1.0, required=False) for name in place)

    def target(kind: str, label: str, arguments: Iterable[Argument] = ()) -> CommandKind:
        return CommandKind(kind, label, tuple(arguments), limit_s=limit, replaceable=replaceable)

    kinds = (
        target("joints", "Move joints", (*joints, share)),
        target("pose", "Move tool", (*there, share)),
        target("line", "Move tool straight", (*there, share)),
        CommandKind("gripper", "Gripper", (Argument("closed", "", 0.0, 1.0, share="closed"),), limit_s=10.0),
        CommandKind("jog_joints", "Turn a joint while held", jog, limit_s=JOG_LONGEST_S, held=True),
        CommandKind("jog_tool", "Move tool while held", tool, limit_s=JOG_LONGEST_S, held=True),
        CommandKind(
            "follow", "Follow the hand", (*HAND, GRIP), level=2, limit_s=FOLLOW_LONGEST_S, held=True, steered=True
        ),
        target("ready", "Ready position"),
        target("home", "Default position"),
        CommandKind("noop", "No operation", limit_s=5.0, moves=False, still_after=False),
    )
    return {one.kind: one for one in kinds}


def joint_scales(arm: Chain, steps: Iterable[float]) -> dict[str, Scale]:
    """Return the scale of each joint for compact states, with these steps (rad)."""
    return {
        joint.name: Scale(joint.low - BEYOND, joint.high + BEYOND, step)
        for joint, step in zip(arm.joints, steps, strict=True)
    }
