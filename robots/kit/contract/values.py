"""The values of a command, checked against the robot's spec."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from robots.kit.contract.capabilities import Check
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import function, spec_of
from robots.kit.contract.ranges import from_to, plain
from robots.kit.contract.session import JSON, RobotState
from robots.kit.contract.spec import Argument, CommandKind, Spec
from robots.kit.plain import storable

SHOWN = 40  # characters of a person's text that an answer repeats
NEAR = 0.01  # of an argument's range: tolerance between the value that was set and the one that the robot shows


def check(name: str, kind: str, args: JSON, settings: JSON, state: RobotState | None = None) -> None:
    """Refuse a command that is known to be wrong at `state` (None: wherever the robot is).

    Raises:
        BadRequest: no such command, or values that it does not take.
        OutOfWorkspace: it would lead where the robot may not go.

    """
    spec = spec_of(name)
    own = spec.capability(Check)
    if own is None:
        within(known_command(spec, kind, args), args)
    else:
        function(own.function)(kind, args, settings, state)


def number(args: dict[str, Any], name: str) -> float:
    """Return a finite number out of `args`. Raises BadRequest."""
    value = args.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadRequest(f"The value {name} must be a number.")
    try:
        real = float(value)
    except OverflowError:
        raise BadRequest(f"The value {name} is too large.") from None
    if not isfinite(real):
        raise BadRequest(f"The value {name} must be a finite number.")
    return real


def text(args: dict[str, Any], argument: Argument) -> str:
    """Return a text out of `args`, which every database and file can store. Raises BadRequest."""
    value = args.get(argument.name)
    if not isinstance(value, str) or not argument.low <= len(value) <= argument.high:
        raise BadRequest(
            f"The value {argument.name} must be a text of {from_to(argument.low, argument.high)} characters."
        )
    if not storable(value):
        raise BadRequest(f"The value {argument.name} contains characters that cannot be stored; use plain text.")
    return value


def not_shown(kind: CommandKind, args: Mapping[str, Any], values: Mapping[str, float]) -> str | None:
    """Return in words which value of a state differs from the one that was set; None if none differs."""
    for argument in kind.arguments:
        channel = kind.shown.get(argument.name)
        if channel is None or argument.name not in args:
            continue
        shown, wanted = values.get(channel), number_for(argument, args[argument.name])
        near = 0.0 if argument.text else NEAR * (argument.high - argument.low)
        if shown is None or not abs(shown - wanted) <= near:
            told = "nothing" if shown is None else f"{shown:g}"
            return f"the robot shows {told} for {channel}, not {wanted:g}."
    return None


def number_for(argument: Argument, value: Any) -> float:
    """Return the number by which a channel shows an argument's value."""
    return float(function(argument.number)(value) if argument.text else value)


def known_command(spec: Spec, kind: str, args: dict[str, Any]) -> CommandKind:
    """Return the command of that kind whose values have the right names.

    Raises:
        BadRequest: no such command, a value that it does not take, a value that is no number.

    """
    if not isinstance(kind, str):
        raise BadRequest("A command has a name.")
    if not isinstance(args, dict):
        raise BadRequest("The values of a command must be an object.")
    found = spec.command(kind)
    if found is None:
        raise BadRequest(f"This robot has no command called {kind[:SHOWN]}.")
    taken = {a.name for a in found.arguments}
    for name in args:
        if name not in taken:
            raise BadRequest(
                f"The command {kind} takes no value called {name[:SHOWN] if isinstance(name, str) else '?'}."
            )
    for argument in found.arguments:
        if argument.text and (argument.required or argument.name in args):
            text(args, argument)
        elif argument.required or argument.name in args:
            number(args, argument.name)
    return found


known = known_command  # its name in 0.1, until 1.0


def within(command: CommandKind, args: dict[str, Any]) -> None:
    """Refuse a value outside its range. Raises BadRequest."""
    for argument in command.arguments:
        if argument.text:
            continue
        if argument.name in args and not argument.low <= number(args, argument.name) <= argument.high:
            low, high = plain(argument.low), f"{plain(argument.high)} {argument.unit}".rstrip()
            raise BadRequest(f"{argument.name} must lie between {low} and {high}.")
        if argument.whole and argument.name in args and number(args, argument.name) % 1:
            raise BadRequest(f"{argument.name} must be a whole number.")
