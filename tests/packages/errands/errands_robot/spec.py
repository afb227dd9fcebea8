"""The spec of the Mercury arm, which is also asked for motions as jobs here."""

from dataclasses import replace

from robots.kit.contract.spec import ANYONE, TURN, Spec
from robots.kit.drivers.mercury.spec import spec as arm


def spec() -> Spec:
    """Return the spec."""
    made = arm()
    commands = [replace(c, asked_by=frozenset({TURN, ANYONE})) if c.kind == "move" else c for c in made.commands]
    return replace(made, commands=tuple(commands))
