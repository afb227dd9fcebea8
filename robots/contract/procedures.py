"""What staff may ask of a robot beside its own commands: the portal carries these out with what its spec declares."""

from robots.contract.capabilities import Calibration
from robots.contract.spec import STAFF, CommandKind, Spec

BY_STAFF = frozenset({STAFF})
RESET = CommandKind("soft_reset", "Soft reset", limit_s=60.0, asked_by=BY_STAFF)
PICTURE = CommandKind("still", "Take a picture", limit_s=60.0, asked_by=BY_STAFF, moves=False)
CALIBRATE = "calibrate"


def procedures(spec: Spec) -> tuple[CommandKind, ...]:
    """Return the procedures that this robot offers to staff."""
    own = spec.capability(Calibration)
    if own is None:
        return (RESET, PICTURE)
    return (RESET, CommandKind(CALIBRATE, own.label, limit_s=own.limit_s, asked_by=BY_STAFF), PICTURE)


def procedure(spec: Spec, kind: str) -> CommandKind | None:
    """Return the procedure of that kind, or None if the robot has none."""
    return next((p for p in procedures(spec) if p.kind == kind), None)
