"""Values of commands: good ones inside the ranges of the spec, and those that a driver has to refuse."""

import math
from collections.abc import Iterator
from typing import Any

from robots.kit.conformance.trial import Trial
from robots.kit.contract.capabilities import Check
from robots.kit.contract.errors import RobotError
from robots.kit.contract.find import function
from robots.kit.contract.session import JSON, RobotState
from robots.kit.contract.spec import Argument, CommandKind
from robots.kit.contract.values import known_command, within

SHARES = (1.0, 0.0, 0.9, 0.1, 0.75, 0.25, 0.5)  # of a range; neighbours lie far apart, so that a motion is long
WILD: tuple[Any, ...] = (math.nan, math.inf, -math.inf, 1e308, -1e308, 10**400)
NO_NUMBERS: tuple[Any, ...] = ("1", None, True, [], {})
NO_TEXTS: tuple[Any, ...] = (1, None, True, [], {})


def refusal(trial: Trial, kind: str, args: JSON, state: RobotState | None) -> BaseException | None:
    """Return what the pure check of the spec raises for a command, None where it lets it pass."""
    own, settings = trial.spec.capability(Check), trial.opened_session().settings
    try:
        if own is None:
            within(known_command(trial.spec, kind, args), args)
        else:
            function(own.function)(kind, args, settings, state)
    except Exception as error:  # noqa: BLE001 - of a package of somebody else
        return error
    return None


def good(trial: Trial, command: CommandKind) -> list[JSON]:
    """Return values with which a command can be carried out here.

    They are the robot's examples, else inside its ranges, else its default.
    """
    found = trial.examples.get(command.kind)
    tried = list(found) if found is not None else list(_inside(command))
    if found is None and not tried and command.default is not None:
        tried = [dict(command.default)]
    state = trial.opened_session().latest()
    return [args for args in tried if refusal(trial, command.kind, args, state) is None]


def base(trial: Trial, command: CommandKind) -> JSON:
    """Return good values, or the middle of the ranges where none are known."""
    middle = {a.name: "x" * max(1, int(a.low)) if a.text else at(a, 0.5) for a in command.arguments if a.required}
    return next(iter(good(trial, command)), middle)


def _inside(command: CommandKind) -> Iterator[JSON]:
    needed = [a for a in command.arguments if a.required]
    if any(a.text for a in needed):
        return
    if not needed and command.arguments and not any(a.text for a in command.arguments):
        yield from ({a.name: at(a, share) for a in command.arguments} for share in SHARES)
    if not needed:
        yield {}
        return
    yield from ({a.name: at(a, share) for a in needed} for share in SHARES)


def at(argument: Argument, share: float) -> float:
    """Return the number at that share of an argument's range."""
    number = argument.low + share * (argument.high - argument.low)
    return float(round(number)) if argument.whole else number


def ends(command: CommandKind, example: JSON) -> Iterator[JSON]:
    """Yield the values with each number at its lowest and at its highest."""
    for argument in command.arguments:
        if not argument.text:
            yield example | {argument.name: argument.low}
            yield example | {argument.name: argument.high}


def bad(command: CommandKind, example: JSON) -> Iterator[JSON]:
    """Yield values that no driver may take: past the range, no numbers, missing, or of another name."""
    for argument in command.arguments:
        name = argument.name
        if argument.text:
            yield from (example | {name: value} for value in NO_TEXTS)
            yield example | {name: "x" * (int(argument.high) + 1)}
            if argument.low >= 1:
                yield example | {name: ""}
        else:
            step = max(1e-3, (argument.high - argument.low) / 1000)
            yield example | {name: argument.low - (1 if argument.whole else step)}
            yield example | {name: argument.high + (1 if argument.whole else step)}
            yield from (example | {name: value} for value in (*WILD, *NO_NUMBERS))
            if argument.whole and argument.high > argument.low:
                yield example | {name: argument.low + 0.5}
        if argument.required:
            yield {key: value for key, value in example.items() if key != name}
    yield example | {"no_such_value": 1.0}


def is_refusal(error: BaseException | None) -> bool:
    """Tell whether an error is one with a sentence for the person."""
    return isinstance(error, RobotError) and bool(str(error).strip())
