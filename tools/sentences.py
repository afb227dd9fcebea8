"""Find the sentences of workers and the labels of robots, which are translated where they are read.

Nothing marks them: a worker knows no reader, and most have names and numbers in them. What counts is their form: a
constant or f-string with two words or more, in the rooms below, that is no docstring and not written to a log.
Those that only integrators, operators of servers and other processes read stay English, as the documentation is.
"""

import ast
import re
import tomllib
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path

from robots.kit.contract.channels import Scalar
from robots.kit.contract.find import spec_of
from robots.kit.contract.procedures import offered_procedures
from robots.kit.contract.spec import Argument

ROOMS = ("robots/kit", "robots/services", "robots/grants.py", "robots/states.py", "workers", "queueing", "portal/live")
# for integrators and server operators
ENGLISH = ("conformance", "migrations", "admin", "prepare", "process", "simulated", "ros")
LOGS = re.compile(
    r"^(_?log|security|logging|parser|re|say|warnings|np|cv2)\.|^(Path|getattr|open|field|Meta|n?gettext(_lazy|_noop)?|pgettext(_lazy)?)$"
)
TWO_WORDS = re.compile(r"[^\W\d_]{2,}[,:]? [^\W\d_]{2,}")
PRINTF = re.compile(r"%[-+0-9.]*[sdgfr]")
FORMAT = re.compile(r"\{[\w.]*(?:![rs])?(?::[^{}]*)?\}")
WORDS = "words"  # the table of plain words for a robot's own
OPTIONAL = re.compile(r"\[([^\[\]]*)\]")  # part of what a command does, see robots/kit/contract/words.py
CODE = re.compile(r"^[a-z]+_\w+$|^d[xyz]$|^r[xyz]$")  # no word
SPOKEN = (
    "label",
    "help",
    "says",
    "nothing",
    "text",
    "language",
    "modes",
    "ends",
    "job",
    "done",
    "once",
    "often",
    "name",
)
LABELS = ("name", "tagline", "label", "title", "help", "says", "reason", "unit_label", "hint", "text")


def sentences(root: Path) -> list[str]:
    """Return the texts, sorted."""
    texts: set[str] = set()
    for room in ROOMS:
        top = root / room
        for path in sorted(top.rglob("*.py")) if top.is_dir() else [top]:
            if not any(part in ENGLISH for part in (*path.relative_to(root).parts[:-1], path.stem)):
                texts.update(of_source(path.read_text()))
    for path in sorted(root.glob("robots/kit/drivers/*/robot.toml")):
        texts.update(of_table(tomllib.loads(path.read_text())))
        driver = path.parent.name
        texts.update(of_spec((spec_of(driver), offered_procedures(driver))))
    return sorted(texts)


def of_source(source: str) -> Iterator[str]:
    """Yield the sentences of a module, with a placeholder for each value."""
    tree = ast.parse(source)
    silent = set(_not_for_people(tree))
    for node in ast.walk(tree):
        if id(node) not in silent and isinstance(node, ast.Constant | ast.JoinedStr):
            text = _template(node)
            if text and TWO_WORDS.search(FORMAT.sub("", text)):
                yield text
    yield from _of_choices(tree)


def of_table(table: object, key: str = "") -> Iterator[str]:
    """Yield the labels of a table of a robot's package."""
    if isinstance(table, dict):
        for name, value in table.items():
            yield from of_table(value, WORDS if key == WORDS else name)
    elif isinstance(table, list):
        for value in table:
            yield from of_table(value, key)
    elif isinstance(table, str) and key in (*LABELS, WORDS) and re.search("[a-z]{2}", table):
        yield table


def of_spec(part: object, key: str = "") -> Iterator[str]:
    """Yield the labels of a robot's spec: of commands, values, settings and so on, and its words for what it does."""
    if isinstance(part, Argument):
        yield from of_spec((part.title, part.help), SPOKEN[0])
        yield from of_spec(part.directions, SPOKEN[0])
    elif is_dataclass(part):
        for field in fields(part):
            if field.name != "name" or isinstance(part, Scalar):
                yield from of_spec(getattr(part, field.name), field.name)
    elif isinstance(part, tuple | list):
        for one in part:
            yield from of_spec(one, key)
    elif (
        isinstance(part, str)
        and key in SPOKEN
        and re.search("[A-Za-z]{2}", part)
        and not (CODE.search(part) or part.isupper())
    ):
        yield OPTIONAL.sub("", part)
        yield OPTIONAL.sub(r"\1", part)


def _of_choices(tree: ast.AST) -> Iterator[str]:
    """Yield the labels of choices, also those of one word."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and any(ast.unparse(base).endswith("Choices") for base in node.bases):
            for value in (one.value for one in node.body if isinstance(one, ast.Assign)):
                label = value.elts[-1] if isinstance(value, ast.Tuple) else None
                label = label.args[0] if isinstance(label, ast.Call) else label  # marked
                if isinstance(label, ast.Constant) and isinstance(label.value, str):
                    yield label.value


def _not_for_people(tree: ast.AST) -> Iterator[int]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield id(node.value)
        elif isinstance(node, ast.JoinedStr):
            yield from (id(part) for part in node.values)
        elif isinstance(node, ast.FormattedValue) and node.format_spec:
            yield from map(id, ast.walk(node.format_spec))
        elif isinstance(node, ast.Call) and LOGS.match(ast.unparse(node.func)):
            yield from (id(part) for argument in node.args for part in ast.walk(argument))


def _template(node: ast.Constant | ast.JoinedStr) -> str:
    """Return the text with `{name}` for each value; names say what the value is, and differ."""
    if isinstance(node, ast.Constant):
        if not isinstance(node.value, str):
            return ""
        names = iter(range(1, 100))
        return FORMAT.sub(lambda _: f"{{{next(names)}}}", PRINTF.sub("{}", node.value))
    text, used = "", set[str]()
    for part in node.values:
        if isinstance(part, ast.Constant):
            text += str(part.value)
        elif isinstance(part, ast.FormattedValue):
            name = _name(part.value)
            name = next(n for n in (name, *(f"{name}{i}" for i in range(2, 100))) if n not in used)
            used.add(name)
            text += f"{{{name}}}"
    return text


def _name(value: ast.expr) -> str:
    if isinstance(value, ast.Attribute):
        return value.attr.strip("_")
    if isinstance(value, ast.Name):
        return value.id.strip("_").lower()
    if isinstance(value, ast.Call):
        return _name(value.args[0] if value.args else value.func)
    return "value"
