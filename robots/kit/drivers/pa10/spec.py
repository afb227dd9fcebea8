"""The spec of the museum arm; readable without its driver."""

from robots.kit.arms.boxes import MORE_BOXES
from robots.kit.arms.described import chain
from robots.kit.arms.object_streams import STREAMS
from robots.kit.arms.objects import objects_of
from robots.kit.arms.tasks.requests import task_capabilities, task_commands
from robots.kit.contract.capabilities import ArmModel, Check, Preview, Programs, Reset
from robots.kit.contract.channels import IN_SPACE, Pose, Scale
from robots.kit.contract.spec import Argument, CommandKind, Spec
from robots.kit.description import load
from robots.kit.drivers.pa10.protocol import LONGEST_PROGRAM_S, Mode
from robots.kit.drivers.stills import stills

HERE = "robots.kit.drivers.pa10"
JOG_LONGEST_S = 20.0
GRIPPER = "gripper"  # the last joint of the state: the opening of each finger, m
FINE, COARSE = 1.2e-5, 3e-5  # rad; together at most 0.03 mm at the tool
PLACE = IN_SPACE.coordinates
LONGEST_TEXT = 6000  # characters of a program that people send; fewer than the wire takes
PLANNED_S = 10.0  # a motion is planned and checked before the answer, which takes longer on a busy machine


def spec() -> Spec:
    """Return the spec, from the description."""
    description, arm = load("pa10"), chain("pa10")
    motion = description["motion"]
    limit = motion["limit_s"] + PLANNED_S
    slowest, fastest = motion["scale_range"]
    share = Argument("speed", "", slowest, fastest, required=False)
    joints = tuple(Argument(j.name, "rad", j.low, j.high) for j in arm.joints)
    place = (
        *(Argument(name, "m", -1.6, 1.6) for name in PLACE[:3]),
        *(Argument(name, "rad", -7.0, 7.0) for name in PLACE[3:]),
    )
    jog = tuple(Argument(name, "", -1.0, 1.0, required=False) for name in arm.names)
    tool = tuple(Argument(name, "", -1.0, 1.0, required=False) for name in PLACE)
    program = (
        Argument("number", "", 1.0, 9999.0, required=False, whole=True),
        Argument("text", "", 1, LONGEST_TEXT, required=False, text=True),
    )
    beyond = 0.02  # rad; an arm that was pushed further out is told in full states
    scales = {
        joint.name: Scale(joint.low - beyond, joint.high + beyond, FINE if n < 3 else COARSE)
        for n, joint in enumerate(arm.joints)
    }
    scales[GRIPPER] = Scale(description["gripper"]["closed"], description["gripper"]["open"], 1e-4)
    return Spec(
        name=description["name"],
        joints=(*arm.names, GRIPPER),
        handover=("ready",),
        rest_s=description["line"]["rest_s"],
        pose=Pose(PLACE, packed=False),  # the console computes it from the joints
        scales=scales,
        streams=STREAMS,
        modes=tuple(mode.replace("_", " ") for mode in Mode),
        capabilities=(
            ArmModel(),
            Reset(),
            Check(f"{HERE}.checks:check"),
            Preview(f"{HERE}.checks:foresee", f"{HERE}.checks:planner_for", STREAMS[0].name),
            Programs("program", "the lines of the arm's own wire"),
            *task_capabilities(objects_of("pa10"), f"{HERE}.checks:check_task_job"),
            stills(description["camera"]),
            MORE_BOXES,
        ),
        commands=(
            CommandKind("joints", "Move joints", (*joints, share), limit_s=limit, replaceable=True),
            CommandKind("pose", "Move tool", (*place, share), limit_s=limit, replaceable=True),
            CommandKind("line", "Move tool straight", (*place, share), limit_s=limit, replaceable=True),
            CommandKind("gripper", "Gripper", (Argument("closed", "", 0.0, 1.0),), limit_s=10.0),
            CommandKind("program", "Program", program, limit_s=LONGEST_PROGRAM_S),
            *task_commands(objects_of("pa10")),
            CommandKind("jog_joints", "Jog joints", jog, limit_s=JOG_LONGEST_S, held=True),
            CommandKind("jog_tool", "Jog tool", tool, limit_s=JOG_LONGEST_S, held=True),
            CommandKind("ready", "Ready position", limit_s=limit, replaceable=True),
            CommandKind("home", "Default position", limit_s=limit, replaceable=True),
            CommandKind("noop", "No operation", limit_s=5.0, moves=False, still_after=False),
        ),
    )
