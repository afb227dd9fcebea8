"""The spec of the PUMA 560; readable without its driver."""

from robots.kit.arms.boxes import MORE_BOXES
from robots.kit.arms.described import chain
from robots.kit.arms.kinds import BEYOND, arm_commands, joint_scales
from robots.kit.arms.object_streams import STREAMS
from robots.kit.arms.objects import objects_of
from robots.kit.arms.tasks.requests import task_capabilities, task_commands, tidy_commands
from robots.kit.contract.capabilities import ArmModel, Check, Preview, Reset, Setting
from robots.kit.contract.channels import IN_SPACE, Pose, Scalar, Scale
from robots.kit.contract.spec import Spec
from robots.kit.description import load
from robots.kit.drivers.puma.protocol import BAUDS
from robots.kit.drivers.stills import stills

HERE = "robots.kit.drivers.puma"
PLANNED_S = 10.0  # a motion is planned and checked before the answer, which takes longer on a busy machine
VALVE = "valve"  # 0 open, 1 closed; what the fingers hold is told by no one
BITS = (18, 18, 18, 16, 16, 16)  # of the joints in compact states: together at most 0.03 mm at the tool
NOT_CALIBRATED, FAULT = "not calibrated", "fault"
MODES = ("idle", "planning", "moving", "jogging", "holding", "calibrating", NOT_CALIBRATED, FAULT)


def spec() -> Spec:
    """Return the spec, from the description."""
    description, arm = load("puma"), chain("puma")
    steps = [(j.high - j.low + 2 * BEYOND) / (2**bits - 2) for j, bits in zip(arm.joints, BITS, strict=True)]
    return Spec(
        name=description["name"],
        joints=arm.names,
        handover=("ready",),
        rest_s=description["line"]["rest_s"],
        pose=Pose(IN_SPACE.coordinates, packed=False),  # the console computes it from the joints
        channels=(Scalar(VALVE, "", 0.0, 1.0),),
        scales=joint_scales(arm, steps) | {VALVE: Scale(0.0, 1.0, 1.0)},
        streams=STREAMS,
        modes=MODES,
        capabilities=(
            ArmModel(),
            Reset(),
            Check(f"{HERE}.checks:check"),
            Preview(f"{HERE}.checks:foresee", f"{HERE}.checks:planner_for", STREAMS[0].name),
            *task_capabilities("puma", f"{HERE}.checks:check_task_job"),
            stills(description["camera"]),
            MORE_BOXES,
            Setting(
                "baud", "Baud rate", unit="baud", low=min(BAUDS), high=max(BAUDS), default=description["line"]["baud"],
                help="9600 or 38400, as the controller is set.",
            ),
        ),
        commands=(
            *arm_commands("puma", PLANNED_S, replaceable=False).values(),
            *task_commands(objects_of("puma")),
            *tidy_commands("puma"),
        ),
    )  # fmt: skip
