"""The forms that ask for a job without scripts: the present choices, or a field for each value of the kind."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from robots.kit.contract.capabilities import JobChoices
from robots.kit.contract.find import function
from robots.kit.contract.spec import Argument, CommandKind
from robots.kit.plain import whole
from robots.models import Robot
from robots.services import programs
from robots.services.streams import packets_of

SHOWN = 200  # programs


@dataclass(frozen=True)
class Field:
    """A value of a kind, and the text that the person wrote."""

    argument: Argument
    written: str = ""


@dataclass(frozen=True)
class Form:
    """The form of one kind. `name`, `mail`: the name that the person wrote, and whether they want a mail.

    `declared`: the robot offers `choices`, pairs of a value and its words, in place of fields. `saved`: id and name of
    the programs that may be named in place of a text, and `more` how many the list leaves out; `program`: the one that
    was chosen.
    """

    kind: CommandKind
    fields: tuple[Field, ...]
    name: str = ""
    mail: bool = False
    declared: JobChoices | None = None
    choices: tuple[tuple[str, str], ...] = ()
    choice: str = ""
    saved: tuple[tuple[int, str], ...] = ()
    more: int = 0
    program: str = ""


def forms(robot: Robot, user: Any, kinds: Iterable[CommandKind], written: Mapping[str, str]) -> list[Form]:
    """Return a form for each kind; the form that was sent (`written`) keeps its values."""
    return [_form(robot, user, kind, written if written.get("kind") == kind.kind else {}) for kind in kinds]


def _choices_of(robot: Robot, kind: CommandKind) -> JobChoices | None:
    return next((one for one in robot.spec().all_of(JobChoices) if one.kind == kind.kind), None)


def _form(robot: Robot, user: Any, kind: CommandKind, written: Mapping[str, str]) -> Form:
    declared = _choices_of(robot, kind)
    found = function(declared.function)(packets_of(robot, declared.stream)) if declared is not None else ()
    choices = tuple((json.dumps(args), words) for words, args in found)
    fields = tuple(Field(a, written.get(f"arg-{a.name}", "")) for a in kind.arguments) if declared is None else ()
    name, mail, choice = written.get("name", ""), written.get("mail") == "yes", written.get("choice", "")
    saved = (
        list(programs.visible(robot, user, kind.kind).values_list("pk", "name"))
        if programs.is_program(robot, kind.kind)
        else []
    )
    return Form(
        kind, fields, name, mail, declared, choices, choice, tuple(saved[:SHOWN]), max(0, len(saved) - SHOWN),
        written.get("program", ""),
    )  # fmt: skip


def values(robot: Robot, kind: CommandKind, written: Mapping[str, str]) -> dict[str, Any]:
    """Return the values of a form; text that is not a number stays text, and the robot's check names it."""
    if "choice" in written and _choices_of(robot, kind) is not None:
        return _chosen(kind, written["choice"])
    if program := written.get("program"):
        return {"program": whole(program)}
    found: dict[str, Any] = {}
    for argument in kind.arguments:
        text = written.get(f"arg-{argument.name}", "").strip()
        if not text and not argument.required:
            continue
        found[argument.name] = text if argument.text else _number(text)
    return found


def _chosen(kind: CommandKind, choice: str) -> dict[str, Any]:
    """Return the arguments of a choice, which the robot's checks judge: anybody may have written it."""
    try:
        told = json.loads(choice)
    except (ValueError, RecursionError):
        told = None
    known = told if isinstance(told, dict) else {}
    return {a.name: known[a.name] for a in kind.arguments if isinstance(known.get(a.name), int | float | str)}


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
