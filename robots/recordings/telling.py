"""The public facts of a command that a recording stores beside its stages, and that everybody may replay."""

from typing import Any

from robots.kit.contract.capabilities import Programs
from robots.models import Command


def public(command: Command) -> dict[str, Any]:
    """Return `args`, the numbers of a command.

    Texts are left out, because they may be a program that its author does not share. So is the person: their page
    names them as long as they have an account and want it.
    """
    if any(one.kind == command.kind for one in command.grant.robot.spec().all_of(Programs)):
        return {"args": {}}
    return {"args": {name: value for name, value in command.args.items() if isinstance(value, int | float)}}
