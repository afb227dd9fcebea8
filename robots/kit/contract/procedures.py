"""Procedures that staff may ask for beside a robot's own commands; the portal carries them out.

Their kinds (`soft_reset`, `calibrate`, `still`) are the portal's own words, the same for every robot, and stand in its
history. Each is offered only where the robot has what it needs: a reset and a calibration that its spec declares, and a
camera that its description names. For tidying up a robot has a command of its own. Labels and limits come from the
declaration.
"""

from robots.kit.contract.capabilities import Calibration, Reset
from robots.kit.contract.find import spec_of
from robots.kit.contract.spec import STAFF, CommandKind, Spec
from robots.kit.contract.tidying import Tidy
from robots.kit.description import load, views

BY_STAFF = frozenset({STAFF})
RESET, CALIBRATE = "soft_reset", "calibrate"
PICTURE = CommandKind("still", "Take a picture", limit_s=60.0, asked_by=BY_STAFF, moves=False)


def procedures(spec: Spec, cameras: int = 0) -> tuple[CommandKind, ...]:
    """Return the procedures that a robot with this spec and so many cameras offers to staff."""
    declared = ((RESET, spec.capability(Reset)), (CALIBRATE, spec.capability(Calibration)))
    own = tuple(
        CommandKind(kind, one.label, limit_s=one.limit_s, asked_by=BY_STAFF)
        for kind, one in declared
        if one is not None
    )
    tidy = spec.capability(Tidy)
    own += tuple(one for one in spec.commands if tidy is not None and one.kind == tidy.kind)
    return (*own, PICTURE) if cameras else own


def offered_procedures(driver: str) -> tuple[CommandKind, ...]:
    """Return the procedures that robots of this driver offer to staff. Raises LookupError."""
    return procedures(spec_of(driver), len(views(load(driver))))


offered = offered_procedures  # its name in 0.1, until 1.0


def procedure(driver: str, kind: str) -> CommandKind | None:
    """Return the procedure of that kind, or None if robots of this driver have none."""
    return next((p for p in offered_procedures(driver) if p.kind == kind), None)
