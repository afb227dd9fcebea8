"""What a recording, which everybody may replay, tells of a command beside its stages."""

from typing import Any

from robots.contract.capabilities import Programs
from robots.models import Command
from robots.states import GrantKind


def public(command: Command) -> dict[str, Any]:
    """Return `args`, the numbers of a command, and `by`, the operator of its turn.

    A text is left out: it may be a program that its author shares with nobody. So is who asked for a job: its page
    names them only where they want it.
    """
    kept = command.grant.robot.spec().capability(Programs)
    of_program = kept is not None and command.kind == kept.kind
    args = {} if of_program else {name: value for name, value in command.args.items() if isinstance(value, int | float)}
    by = command.issued_by if command.grant.kind == GrantKind.TURN else None
    return {"args": args, "by": by.get_username() if by and by.pk == command.grant.holder_id else ""}
