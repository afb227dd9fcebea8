"""The forms that ask for a job without scripts: a field for each value of the kind, with what was written into it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from robots.contract.spec import Argument, CommandKind


@dataclass(frozen=True)
class Field:
    """A value of a kind, and what the person wrote."""

    argument: Argument
    written: str = ""


@dataclass(frozen=True)
class Form:
    """The form of one kind. `name`, `mail`: what the person wrote and chose there."""

    kind: CommandKind
    fields: tuple[Field, ...]
    name: str = ""
    mail: bool = False


def forms(kinds: Iterable[CommandKind], written: Mapping[str, str]) -> list[Form]:
    """Return a form for each kind; the one that was sent, by `written`, keeps what the person wrote."""
    return [_form(kind, written if written.get("kind") == kind.kind else {}) for kind in kinds]


def _form(kind: CommandKind, written: Mapping[str, str]) -> Form:
    fields = tuple(Field(a, written.get(f"arg-{a.name}", "")) for a in kind.arguments)
    return Form(kind, fields, written.get("name", ""), written.get("mail") == "yes")


def values(kind: CommandKind, written: Mapping[str, str]) -> dict[str, Any]:
    """Return the values of a form; text that is not a number stays text, and the robot's check names it."""
    found: dict[str, Any] = {}
    for argument in kind.arguments:
        text = written.get(f"arg-{argument.name}", "").strip()
        if not text and not argument.required:
            continue
        found[argument.name] = text if argument.text else _number(text)
    return found


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
