"""Find the sentences of workers and the labels of robots, which are translated where they are read.

Nothing marks them: a worker knows no reader, and most have names and numbers in them. What counts is their form, in the
rooms below: a constant or f-string with two words or more, an f-string that begins with a word, the labels of choices,
and what specs and robot.toml call things. Docstrings, logs and texts that are marked already are left out. So is what
only integrators, operators of servers and other processes read: that stays English, as the documentation is.
"""

import ast
import re
import sys
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import fields, is_dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from robots.kit.contract.capabilities import Statistics
from robots.kit.contract.find import spec_of
from robots.kit.contract.procedures import offered_procedures
from robots.kit.contract.spec import Argument, Spec
from robots.kit.contract.words import called, is_relative
from robots.kit.vision.stability import VERDICTS

ROOMS = (
    "robots/kit", "robots/services", "robots/recordings", "robots/grants.py", "robots/states.py", "workers", "queueing",
    "portal/live", "portal/stores.py", "portal/web/alerts/needs.py",
)  # fmt: skip
ENGLISH = (  # folders and modules of which no page shows a text
    "conformance", "prepare", "ros",  # for integrators
    "migrations", "admin", "process", "simulated",  # for operators of servers
    "rosbridge", "container",  # answers to other programs, descriptions in files for them
    "goals", "objects", "described", "slam", "gridmap",  # checks of robot.toml and of a program's own numbers
    "apps", "captions",  # names for the admin; lines in the pictures of movies, which nobody can translate
    "beds",  # what is hidden, which nobody shall read in a page's script
    "spec",  # `of_spec` has their labels; of the contract: what is wrong with a spec
)  # fmt: skip
# Errors of packages, packets and other programs; the modules whose errors of these kinds are answers to people.
INTERNAL = re.compile(
    "ValueError|TypeError|LookupError|BadDescription|BadMap|FormError|FrameError|NumberError|Malformed|OutOfBounds"
)
PROTOCOLS = ("irat/protocol.py", "srv1/protocol.py")  # no line of these is written by people
ANSWERS = (
    "pa10/protocol.py", "srv1/missions.py", "rovers/fuzzy.py", "rovers/fuzzy_check.py", "rovers/fuzzy_text.py",
    "contract/command_packet.py",
)  # fmt: skip
LOGS = re.compile(
    r"(_?log|security|logging|parser|re|say|warnings|np|cv2|models|sys\.stderr)\..*"
    r"|Path|getattr|cast|open|field|Meta|n?gettext(_lazy|_noop)?|pgettext(_lazy)?"
)
TWO_WORDS = re.compile(r"([^\W\d_]{2,}|\b[aA])[,:]? (\d+ )?[^\W\d_]{2,}")
ONE_WORD = re.compile(r"(?!(?:cm|mm|min) *\b)\b[^\W\d_]{2,}:? | (?!(?:cm|mm|min)\b)[a-z]{2,}\b")  # "Line {n}: {error}."
CODE = re.compile(r"^(SELECT|PRAGMA|INSERT|UPDATE|DELETE) |^(Basic|Digest) |#\{|\\|\(\?")  # queries, headers, patterns
PRINTF = re.compile(r"%[-+0-9.]*[sdgfr]")
FORMAT = re.compile(r"\{[\w.]*(?:![rs])?(?::[^{}]*)?\}")
LABELS = ("name", "tagline", "label", "title", "help", "reason", "unit_label", "hint", "nothing", "language",
          "once", "often", "puzzle", "modes", "ends", "directions", "job", "done", "against", "over_time", "joints", "coordinates", "words")  # fmt: skip
WORDS = "words"  # the table of plain words for a robot's own
WRITERS = ("steps.words", "steps._lines", "missions.__str__", "fuzzy_text.write")  # of languages of tasks and rules
TOLD = ("Observation", "Progress")  # their texts have one word at times
KEYS = ("goal", "feature")  # tables of robot.toml whose names no page shows
WORD, NAME = re.compile("[A-Za-z][a-z]"), re.compile("[a-z]{3}")
OPTIONAL = re.compile(r"\[([^\[\]]*)\]")  # a part of `CommandKind.says`


def sentences(root: Path) -> list[str]:
    """Return the texts, sorted."""
    texts: set[str] = set(VERDICTS)
    for room in ROOMS:
        top = root / room
        for path in sorted(top.rglob("*.py")) if top.is_dir() else [top]:
            folders = path.relative_to(root).parts[:-1]
            if not {*folders, path.stem} & {*ENGLISH} and not str(path).endswith(PROTOCOLS):
                texts.update(of_source(path.read_text(), path))
    for path in sorted(root.glob("robots/kit/drivers/*/robot.toml")):
        texts.update(of_table(tomllib.loads(path.read_text())))
        spec = spec_of(path.parent.name)
        texts.update((*of_spec(spec), *of_jobs(spec.capability(Statistics) or Statistics())))
        texts.update(procedure.label for procedure in offered_procedures(path.parent.name))
        texts.update(of_programs(path.parent))
    return sorted(texts)


def of_package(folder: Path) -> list[str]:
    """Return the texts of a robot's own package, sorted; its spec is imported."""
    texts = {
        text
        for path in folder.rglob("*.py")
        if path.stem not in ("simulator", "spec")
        for text in of_source(path.read_text(), path)
    }
    sys.path.insert(0, str(folder.parent))
    described = tomllib.loads((folder / "robot.toml").read_text())
    spec = replace(import_module(f"{folder.name}.spec").spec(), words=described.get(WORDS, {}))
    texts.update((*of_spec(spec), *of_jobs(spec.capability(Statistics) or Statistics())))
    return sorted({*texts, *of_table(described), *of_programs(folder)})


def of_programs(folder: Path) -> Iterator[str]:
    """Yield the names of the programs that come with a robot."""
    for path in sorted(folder.glob("programs/**/*.txt")):
        yield path.read_text().partition("\n")[0].removeprefix("#").strip()


def of_source(source: str, path: Path = Path("module.py")) -> Iterator[str]:
    """Yield the sentences of a module, with a placeholder for each value."""
    tree = ast.parse(source)
    silent = set(_not_for_people(tree, path))
    for node in ast.walk(tree):
        if id(node) not in silent and isinstance(node, ast.Constant | ast.JoinedStr):
            text = _template(node).strip()
            few = ONE_WORD if isinstance(node, ast.JoinedStr) else TWO_WORDS
            if few.search(FORMAT.sub("0", text)) and not CODE.search(text):
                yield text
        elif id(node) not in silent and isinstance(node, ast.FormattedValue | ast.Call):
            yield from filter(WORD.search, _chosen(node))
        elif isinstance(node, ast.ClassDef) and any("Choices" in ast.unparse(base) for base in node.bases):
            yield from _of_choices(node)


def of_table(table: object, key: str = "") -> Iterator[str]:
    """Yield the labels of a table of a robot's package."""
    if isinstance(table, dict):
        for name, value in table.items():
            unseen = name == "name" and key in KEYS
            yield from () if unseen else of_table(value, WORDS if key == WORDS else name)
    elif isinstance(table, list):
        for value in table:
            yield from of_table(value, key)
    elif isinstance(table, str) and key in LABELS and WORD.search(table) and "_" not in table:
        yield str(table)


def of_spec(spec: Spec) -> Iterator[str]:
    """Yield the labels of a spec, and what `contract/words.py` makes of its commands."""
    yield from of_table(_labels(spec))
    yield from (name for name in spec.names() if NAME.search(name))
    coordinates = spec.pose.coordinates if spec.pose else ()
    for scalar in spec.pose.scalars() if spec.pose else ():
        yield from _of_argument(spec, Argument(scalar.name, scalar.unit, scalar.low, scalar.high))
    for command in spec.commands:
        if command.says:
            yield from (OPTIONAL.sub("", command.says), OPTIONAL.sub(r"\1", command.says))
        if any(is_relative(argument) and argument.name in coordinates for argument in command.arguments):
            yield f"{command.label} to {{words}}"
        for argument in command.arguments:
            yield from () if argument.text else _of_argument(spec, argument)
            yield from [argument.title] if NAME.search(argument.title) else []


def of_jobs(declared: Statistics) -> Iterator[str]:
    """Yield what a page of statistics calls one job, several, and one that is done."""
    yield from (declared.job, f"{declared.job}s", declared.done)


def _of_argument(spec: Spec, argument: Argument) -> Iterator[str]:
    """Yield an argument with its value in words."""
    if argument.share:
        yield f"{{number}} % {argument.share}"
        return
    if argument.directions and not argument.unit:
        yield from argument.directions
        return
    for unit in {"m": (" cm", " m"), "rad": ("°",)}.get(argument.unit, (f" {argument.unit}".rstrip(),)):
        if argument.directions:
            yield from (f"{{number}}{unit} {direction}" for direction in argument.directions)
        elif argument.label and argument.unit:
            yield f"{{number}}{unit} {argument.label}"
        elif NAME.search(title := called(spec, argument)):
            yield f"{title} {{number}}{unit}"


def _labels(part: Any) -> Any:
    """Return the fields of dataclasses as tables, without the words of the wire."""
    if is_dataclass(part):
        shown = {f.name: getattr(part, f.name) for f in fields(part) if f.name not in ("name", "pick", "put")}
        return {"label" if name == "text" else name: _labels(value) for name, value in shown.items()}
    if isinstance(part, tuple | list):
        return [_labels(one) for one in part]
    return part


def _chosen(node: ast.FormattedValue | ast.Call) -> Iterator[str]:
    """Yield words that stand in a text of their own: one of several in an f-string, or what a robot tells a page."""
    if isinstance(node, ast.Call):
        parts = node.args[:1] if ast.unparse(node.func) in TOLD else []
        options = [*parts, *(one for part in parts if isinstance(part, ast.IfExp) for one in (part.body, part.orelse))]
    else:
        options = [one for part in ast.walk(node.value) for one in _options(part)]
    yield from (one.value for one in options if isinstance(one, ast.Constant) and isinstance(one.value, str))


def _options(node: ast.AST) -> list[ast.expr]:
    if isinstance(node, ast.IfExp):
        return [node.body, node.orelse]
    return node.values if isinstance(node, ast.BoolOp) else node.elts if isinstance(node, ast.Tuple) else []


def _of_choices(node: ast.ClassDef) -> Iterator[str]:
    """Yield the labels of choices, marked or not."""
    for value in (one.value for one in node.body if isinstance(one, ast.Assign)):
        label = value.elts[-1] if isinstance(value, ast.Tuple) else None
        label = label.args[0] if isinstance(label, ast.Call) else label
        if isinstance(label, ast.Constant):
            yield str(label.value)


def _not_for_people(tree: ast.AST, path: Path) -> Iterator[int]:
    answers = str(path).endswith(ANSWERS)
    for node in ast.walk(tree):
        parts: Iterable[ast.AST] = ()
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            parts = [node.value]
        elif isinstance(node, ast.JoinedStr):
            parts = [part for part in node.values if isinstance(part, ast.Constant)]
        elif isinstance(node, ast.FormattedValue) and node.format_spec:
            parts = ast.walk(node.format_spec)
        elif isinstance(node, ast.Call):
            called = ast.unparse(node.func)
            if LOGS.fullmatch(called) or (INTERNAL.fullmatch(called) and not answers):
                parts = [part for given in (*node.args, *node.keywords) for part in ast.walk(given)]
        elif isinstance(node, ast.ClassDef) and "models.Model" in map(ast.unparse, node.bases):
            named = [one for one in node.body if getattr(one, "name", "") in ("Meta", "__str__")]
            parts = (part for one in named for part in ast.walk(one))  # the admin's
        elif isinstance(node, ast.FunctionDef) and f"{path.stem}.{node.name}" in WRITERS:
            parts = ast.walk(node)
        elif isinstance(node, ast.AnnAssign | ast.arg) and node.annotation:
            parts = ast.walk(node.annotation)
        elif isinstance(node, ast.keyword) and node.arg == "dispatch_uid":
            parts = ast.walk(node.value)
        yield from map(id, parts)


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
        elif isinstance(part, ast.FormattedValue) and not text.endswith("}"):  # values side by side are one
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
