"""The public facts of a command that a recording stores beside its stages, and that everybody may replay."""

from typing import Any

from robots.kit.contract.capabilities import Programs
from robots.models import Command


def public(command: Command) -> dict[str, Any]:
    """Return `args`, the numbers of a command.

    Texts are left out, because they may be a program that its author does not share. So is the person: their page
    names them as long as they have an account and want it.
    """
    programs = command.grant.robot.spec().capability(Programs)
    if programs is not None and command.kind == programs.kind:
        return {"args": {}}
    return {"args": {name: value for name, value in command.args.items() if isinstance(value, int | float)}}
