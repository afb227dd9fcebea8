"""The spec of the museum arm; readable without its driver."""

from robots.kit.arms.boxes import MORE_BOXES
from robots.kit.arms.described import chain
from robots.kit.arms.kinds import arm_commands, joint_scales
from robots.kit.arms.object_streams import STREAMS
from robots.kit.arms.objects import objects_of
from robots.kit.arms.tasks.requests import task_capabilities, task_commands, tidy_commands
from robots.kit.contract.capabilities import ArmModel, Check, Preview, Programs, Reset
from robots.kit.contract.channels import IN_SPACE, Pose, Scale
from robots.kit.contract.spec import Argument, CommandKind, Spec
from robots.kit.description import load
from robots.kit.drivers.pa10.protocol import LONGEST_PROGRAM_S, Mode
from robots.kit.drivers.stills import stills

HERE = "robots.kit.drivers.pa10"
GRIPPER = "gripper"  # the last joint of the state: the opening of each finger, m
FINE, COARSE = 1.2e-5, 3e-5  # rad; together at most 0.03 mm at the tool
LONGEST_TEXT = 6000  # characters of a program that people send; fewer than the wire takes
PLANNED_S = 10.0  # a motion is planned and checked before the answer, which takes longer on a busy machine


def spec() -> Spec:
    """Return the spec, from the description."""
    description, arm = load("pa10"), chain("pa10")
    kinds = arm_commands("pa10", PLANNED_S, replaceable=True)
    program = (
        Argument("number", "", 1.0, 9999.0, required=False, whole=True),
        Argument("text", "", 1, LONGEST_TEXT, required=False, text=True),
    )
    scales = joint_scales(arm, (FINE,) * 3 + (COARSE,) * 3)
    scales[GRIPPER] = Scale(description["gripper"]["closed"], description["gripper"]["open"], 1e-4)
    return Spec(
        name=description["name"],
        joints=(*arm.names, GRIPPER),
        handover=("ready",),
        rest_s=description["line"]["rest_s"],
        pose=Pose(IN_SPACE.coordinates, packed=False),  # the console computes it from the joints
        scales=scales,
        streams=STREAMS,
        modes=tuple(mode.replace("_", " ") for mode in Mode),
        capabilities=(
            ArmModel(),
            Reset(),
            Check(f"{HERE}.checks:check"),
            Preview(f"{HERE}.checks:foresee", f"{HERE}.checks:planner_for", STREAMS[0].name),
            Programs("program", "the lines of the arm's own wire"),
            *task_capabilities("pa10", f"{HERE}.checks:check_task_job"),
            stills(description["camera"]),
            MORE_BOXES,
        ),
        commands=(
            *map(kinds.__getitem__, ("joints", "pose", "line", "gripper")),
            CommandKind("program", "Program", program, limit_s=LONGEST_PROGRAM_S),
            *task_commands(objects_of("pa10")),
            *tidy_commands("pa10"),
            *map(kinds.__getitem__, ("jog_joints", "jog_tool", "follow", "ready", "home", "noop")),
        ),
    )
