"""Keep the catalogues of translations.

    .venv/bin/python tools/translations.py update   read all texts from the sources into locale/*/LC_MESSAGES/*.po
    .venv/bin/python tools/translations.py compile  make the files that the portal reads, and the pseudo-language
    .venv/bin/python tools/translations.py missing  print the texts without a translation; status 1 if there are any

`django.po` has what templates and views mark, the names of models and their fields, and the questions of clearance
tests. `djangojs.po` has what browsers translate: the texts of the scripts, and the sentences and labels of workers and
robots, which nothing marks (tools/sentences.py says which those are).

With a folder after the command it is done for the package of a robot, in its folder `locale`.
"""

import io
import json
import os
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import django
from babel.messages import Catalog, Message
from babel.messages.extract import extract_python
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po, write_po
from django.utils.translation import override
from django.utils.translation.template import templatize

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from portal.languages import LANGUAGES, PSEUDO  # noqa: E402 - the folder is known now
from portal.web.translation.names import CONTEXT, names_of, own_models  # noqa: E402
from robots.kit.contract.excavation import Excavation  # noqa: E402
from robots.kit.contract.find import function, spec_of  # noqa: E402
from tools.sentences import of_package as sentences_of_package  # noqa: E402
from tools.sentences import sentences  # noqa: E402

LOCALE = ROOT / "portal" / "locale"
PYTHON = ("portal", "accounts", "queueing", "operatorlog", "robots", "workers")
KEYWORDS: dict[str, tuple[object, ...] | None] = {
    "gettext": None, "gettext_lazy": None, "gettext_noop": None,
    "ngettext": (1, 2), "ngettext_lazy": (1, 2), "pgettext": ((1, "c"), 2), "pgettext_lazy": ((1, "c"), 2),
}  # fmt: skip
COMMENTS = ["Translators:"]
PIECE = "piece"  # the context of names of hidden pieces
WORDS = re.compile(r"\{\w*\}|%\(\w+\)[sd]|%[sd%]|<[^<>]*>|&\w+;|[^\W\d_]+")
LITERAL = r"""(?:"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')"""
TEXT = rf"({LITERAL}(?:\s*\+\s*{LITERAL})*)\s*(?=[,)])"
CALL = re.compile(rf"(?<![\w.#])(n?gettext)\(\s*{TEXT}(?:,\s*{TEXT})?")
Found = tuple[str, str | tuple[str, ...], list[str]]  # keyword, texts, comments


def main(command: str, folder: str = "") -> int:
    """Run a command for the portal, or for the package of a robot in that folder. Return the exit status."""
    package = Path(folder).resolve() if folder else None
    return {"update": update, "compile": compile_all, "missing": missing}[command](package)


def update(package: Path | None) -> int:
    """Write the texts of the sources into every catalogue; translations stay."""
    for domain, template in of_package(package) if package else (("django", marked()), ("djangojs", unmarked())):
        for path in catalogues(domain, package):
            catalogue = read(path)
            catalogue.update(template, no_fuzzy_matching=True, update_creation_date=False)
            catalogue.obsolete.clear()
            with path.open("wb") as file:
                write_po(file, catalogue, width=120, no_location=True, sort_output=True, ignore_obsolete=True)
    return 0


def compile_all(package: Path | None) -> int:
    """Make `.mo` files."""
    for domain in ("django", "djangojs"):
        for path in catalogues(domain, package):
            catalogue = read(path)
            write_binary(path.with_suffix(".mo"), catalogue)
        if package:
            continue  # the pseudo-language is for the portal's own texts
        folder = LOCALE / "ar_XB" / "LC_MESSAGES"
        folder.mkdir(parents=True, exist_ok=True)
        write_binary(folder / f"{domain}.mo", pseudo(catalogue))
    return 0


def missing(package: Path | None) -> int:
    """Print what has no translation."""
    paths = [path for domain in ("django", "djangojs") for path in catalogues(domain, package)]
    texts = [(path, text) for path in paths for text in gaps(read(path))]
    for path, text in texts:
        sys.stdout.write(f"{path.relative_to(package or ROOT)}: {text!r}\n")
    return int(bool(texts))


def catalogues(domain: str, package: Path | None) -> list[Path]:
    """Return the catalogue of each language but English."""
    locale, codes = package / "locale" if package else LOCALE, [code for code, _ in LANGUAGES]
    return [locale / code / "LC_MESSAGES" / f"{domain}.po" for code in codes if code not in ("en", PSEUDO[0])]


def of_package(package: Path) -> tuple[tuple[str, Catalog], ...]:
    """Return the texts of a robot's own package by domain: its clearance test, and everything else."""
    test, other = Catalog(project=package.name, fuzzy=False), Catalog(project=package.name, fuzzy=False)
    for text in of_test((package / "clearance.toml").read_text()):
        test.add(text)
    for path in (package / "console").rglob("*.[jt]s"):
        add(other, of_script(path.read_text()))
    for text in sentences_of_package(package):
        other.add(text)
    return ("django", test), ("djangojs", other)


def read(path: Path) -> Catalog:
    """Return a catalogue; an empty one if the file is not there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    language = path.parts[-3]
    if not path.exists():
        return Catalog(locale=language, project="Farhand", fuzzy=False)
    with path.open("rb") as file:
        return read_po(file, locale=language)


def gaps(catalogue: Catalog) -> list[str]:
    """Return the texts without a translation, or with one of an earlier form (fuzzy), which is left out."""
    return [
        str(m.id)
        for m in catalogue
        if m.id and (m.fuzzy or not (all(m.string) if isinstance(m.string, tuple | list) else m.string))
    ]


def write_binary(path: Path, catalogue: Catalog) -> None:
    """Write the file that gettext reads; another process sees the old one or the new one, whole."""
    out = io.BytesIO()
    write_mo(out, catalogue)
    part = path.with_suffix(".part")
    part.write_bytes(out.getvalue())
    part.replace(path)


def marked() -> Catalog:
    """Return the texts that templates and Python mark."""
    catalogue = Catalog(project="Farhand", fuzzy=False)
    consoles = (ROOT / "robots/kit/drivers").glob("*/console/*.html")
    for path in sorted([*(ROOT / "templates").rglob("*.*"), *consoles]):
        if path.suffix in (".html", ".txt"):
            lines = templatize(path.read_text(), origin=str(path)).splitlines()
            add(catalogue, extract(io.BytesIO("\n".join(line.strip() for line in lines).encode()), extract_python))
    for room in PYTHON:
        for path in sorted((ROOT / room).rglob("*.py")):
            add(catalogue, extract(io.BytesIO(path.read_bytes()), extract_python))
    for text in of_models():
        catalogue.add(text, context=CONTEXT)
    for path in sorted((ROOT / "robots/kit/drivers").glob("*/clearance.toml")):
        for text in of_test(path.read_text()):
            catalogue.add(text)
        for text in of_pieces(path.parent.name):
            catalogue.add(text, context=PIECE)
    return catalogue


def of_models() -> list[str]:
    """Return the names that models and their fields have from the code, sorted: what shows them marks nothing."""
    os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")
    django.setup()
    with override(None):
        return sorted({str(name) for model in own_models() for _, _, name in names_of(model)})


def of_pieces(driver: str) -> list[str]:
    """Return the names of hidden pieces. They are not in the catalogue of scripts, where people would read them."""
    declared = spec_of(driver).capability(Excavation)
    return [one.name for one in function(declared.pieces)("", 1)] if declared is not None and declared.pieces else []


def of_test(source: str) -> Iterator[str]:
    """Yield the texts of a `clearance.toml`; its questions become rows, which are translated where they are read."""
    for question in tomllib.loads(source)["question"]:
        yield question["text"]
        yield from question["choices"]
        yield from (question[name] for name in ("topic", "explanation") if name in question)


def unmarked() -> Catalog:
    """Return the texts that scripts mark, and the sentences and labels of workers and robots."""
    catalogue = Catalog(project="Farhand", fuzzy=False)
    for path in [*(ROOT / "frontend/src").rglob("*.ts"), *(ROOT / "robots/kit/drivers").glob("*/console/**/*.ts")]:
        add(catalogue, of_script(path.read_text()))
    for text in sentences(ROOT):
        catalogue.add(text)
    return catalogue


def extract(file: io.BytesIO, method: object) -> Iterator[Found]:
    """Yield the calls of a translating function in a source file."""
    for _, name, texts, comments in method(file, list(KEYWORDS), COMMENTS, {}):  # type: ignore[operator]
        if name:
            yield name, texts, comments


def of_script(source: str) -> Iterator[Found]:
    """Yield the calls of `gettext` and `ngettext` in TypeScript whose texts are literals, also within templates.

    Babel's own reader takes a `<` of TypeScript for markup, and does not look into templates.
    """
    for call in CALL.finditer(source):
        texts = tuple(_joined(literals) for literals in call.groups()[1:] if literals)
        yield call[1], texts if len(texts) > 1 else texts[0], []


def _joined(literals: str) -> str:
    """Return the text of literals with + between them."""
    return "".join(_unquoted(literal[0]) for literal in re.finditer(LITERAL, literals))


def _unquoted(literal: str) -> str:
    inner = literal[1:-1]
    return str(
        json.loads(f'"{inner}"' if literal[0] == '"' else '"' + inner.replace("\\'", "'").replace('"', '\\"') + '"')
    )


def add(catalogue: Catalog, found: Iterator[Found]) -> None:
    """Add texts to a catalogue."""
    for name, texts, comments in found:
        parts = texts if isinstance(texts, tuple) else (texts,)
        if not parts[0]:
            continue  # not a constant
        if name.startswith("ngettext"):
            catalogue.add(parts[:2], auto_comments=comments)
        elif name.startswith("pgettext"):
            catalogue.add(parts[1], context=parts[0], auto_comments=comments)
        else:
            catalogue.add(parts[0], auto_comments=comments)


def pseudo(catalogue: Catalog) -> Catalog:
    """Return the catalogue of the pseudo-language: every word of the English, longer and from right to left."""
    made = Catalog(project="Farhand", fuzzy=False, locale="en")
    for message in catalogue:
        if message.id:
            made[message.id] = turned(message)
    return made


def turned(message: Message) -> Message:
    """Return a message with its words turned."""
    ids = message.id if isinstance(message.id, tuple | list) else (message.id,)
    texts = tuple(WORDS.sub(_turn, text) for text in ids)
    return Message(message.id, texts if len(texts) > 1 else texts[0], context=message.context, flags=message.flags)


def _turn(word: re.Match[str]) -> str:
    text = word[0]
    longer = text + text[-1] * (len(text) // 4)
    return f"\u202e{longer}\u202c" if text[0].isalpha() else text


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
