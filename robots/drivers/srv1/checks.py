"""What the rover refuses before it moves: a place where it cannot stand, beside the ranges of the spec."""

from robots.contract.find import spec_of
from robots.contract.session import JSON, RobotState
from robots.contract.values import known, number, within
from robots.drivers.srv1.ways import way


def check(kind: str, args: JSON, settings: JSON, state: RobotState | None) -> None:
    """Raise BadRequest or OutOfWorkspace where a command cannot be carried out from where the rover is."""
    within(known(spec_of("srv1"), kind, args), args)
    if kind == "go":
        place = number(args, "x"), number(args, "y")
        here = state.pose[:2] if state is not None and len(state.pose) == 3 else place
        way((here[0], here[1]), place)
