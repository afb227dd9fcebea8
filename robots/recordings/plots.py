"""The data of a robot's path for a movie and a page: the commands that planned it, and the findings on it."""

from typing import Any

from robots.kit.clock import ms_of
from robots.kit.contract.capabilities import ArmModel, FloorPlan, Preview
from robots.kit.contract.excavation import Excavation
from robots.kit.contract.planar import PlanarArm
from robots.kit.contract.ranges import readable
from robots.kit.recording.paths import IN_PLANE, PREVIEWS
from robots.models import Finding, Recording
from robots.recordings.findings import findings_of


def plot_of(recording: Recording) -> dict[str, Any] | None:
    """Return the data of the path for the process that makes movies; None for what neither rolls nor is an arm.

    `commands` holds their kinds, arguments and begins, from which previews are computed. `near`: the plot shows what an
    arm has near it, because its table is much larger. `works`: the command that does the robot's work, whose places are
    marked. The data contain no secret.
    """
    robot = recording.robot
    try:
        spec = robot.spec()
    except LookupError:  # its package is gone
        return None
    arm, digs = spec.carried() != IN_PLANE, spec.capability(Excavation)
    if arm and spec.capability(ArmModel) is None and spec.capability(PlanarArm) is None:
        return None
    begun = recording.grant.commands.exclude(sent_at=None).order_by("id")[:PREVIEWS] if spec.capability(Preview) else ()
    return {
        "name": robot.full_name, "driver": robot.driver, "of_tool": arm,
        "near": arm and spec.capability(FloorPlan) is None,
        "works": {"kind": digs.kind, "label": digs.often} if digs is not None else None,
        "settings": {name: value for name, value in robot.driver_settings().items() if name != "token"},
        "labels": {command.kind: command.label for command in spec.commands},
        "commands": [{"at_ms": ms_of(c.sent_at), "kind": c.kind, "args": c.args} for c in begun if c.sent_at],
        "findings": [_told(finding) for finding in findings_of([recording.grant_id])],
    }  # fmt: skip


def _told(finding: Finding) -> dict[str, Any]:
    """Return time, readings and place of a finding, without its text, which only its author may read."""
    values = finding.readings()
    read = ", ".join(f"{name} {readable(value)} {unit}".strip().replace(" ", "\xa0") for name, value, unit in values)
    place = finding.pose[:2] if finding.frame_id is not None and len(finding.pose) == len(IN_PLANE) else None
    return {"at_ms": ms_of(finding.at), "number": finding.number, "place": place, "text": read}
