"""The facts of a command that a recording tells beside its stages; everybody may replay them."""

from typing import Any

from robots.kit.contract.capabilities import Programs
from robots.models import Command


def public(command: Command) -> dict[str, Any]:
    """Return `args`, the numbers of a command.

    A text is left out: it may be a program that its author shares with nobody. So is who gave it: their page names
    them, as long as they have an account and want it.
    """
    kept = command.grant.robot.spec().capability(Programs)
    of_program = kept is not None and command.kind == kept.kind
    return {
        "args": {} if of_program else {n: value for n, value in command.args.items() if isinstance(value, int | float)}
    }
