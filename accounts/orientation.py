"""Renders the orientation with an anchor for each paragraph, so that the test can refer to it, and its picture.

A robot's orientation names a control as `[Up](control:up)`: by the id of its element on the robot's page, or by its
command. The folder `orientation` beside it has pictures of that page and says where each control is
(`tests/e2e/orientation_pictures.py`); text and picture then have the same numbers.

`orientation.de.md` has the same text in German: the same sections, paragraphs and controls in the same order. The
anchors are those of the English text, so that a question refers to its paragraph in every language.

The last section may have the English heading "More, for later": it is folded on the page, and the test asks nothing
of it.
"""

import json
import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.token import Token

from robots.kit import description

CONTROL = "control:"
LOOKS = ("wide-light", "wide-dark", "narrow-light", "narrow-dark")
LOOK = re.compile(rf"(?:([a-z]{{2,3}})-)?({'|'.join(LOOKS)})")
FOLDER, PLACES = "orientation", "places.json"
LATER = "More, for later"
ENGLISH = "en"


@dataclass(frozen=True)
class Rendered:
    """The orientation's HTML, the anchor of each paragraph by section and number from 1, and the controls it names.

    A section is named by its English heading; `headings` has the one of the text. Controls are in the order of their
    numbers. `language` is the code of the text's language.
    """

    html: str
    anchors: dict[tuple[str, int], str]
    controls: tuple[str, ...]
    headings: dict[str, str]
    language: str


def anchor(section: str, paragraph: int) -> str:
    """Return the anchor of a paragraph or list item on the page."""
    return f"{re.sub(r'[^a-z0-9]+', '-', section.lower()).strip('-')}-{paragraph}"


def orientation(driver: str, language: str) -> Rendered:
    """Return a robot's orientation in a language; in English where its package has none that fits the English text.

    Raises OSError or ImportError if there is no English text either.
    """
    english = render(description.text_of(driver, "orientation.md"))
    try:
        source = description.text_of(driver, f"orientation.{language}.md")
    except OSError:
        return english
    found = render(source, tuple(english.headings), language)
    return found if _order(found) == _order(english) else english


def heading(driver: str, section: str, language: str) -> str:
    """Return the heading, in a language, of the section of the orientation that has the English heading `section`."""
    try:
        return orientation(driver, language).headings.get(section, section)
    except (OSError, ImportError):
        return section


def _order(text: Rendered) -> tuple[Any, ...]:
    return list(text.anchors), text.controls, list(text.headings)


def render(source: str, sections: tuple[str, ...] = (), language: str = ENGLISH) -> Rendered:
    """Render Markdown; HTML in it is escaped. List items count as paragraphs.

    `sections` are the headings of the English text if `source` is a translation.
    """
    markdown = MarkdownIt("commonmark", {"html": False})
    tokens = markdown.parse(source)
    anchors: dict[tuple[str, int], str] = {}
    controls: dict[str, int] = {}
    headings: dict[str, str] = {}
    section, number, depth = "", 0, 0
    folded: int | None = None
    for index, token in enumerate(tokens):
        if token.type == "heading_open":
            title, number = tokens[index + 1].content, 0
            section = sections[len(headings)] if len(headings) < len(sections) else title
            headings[section] = title
            if section == LATER:
                folded, token.tag, tokens[index + 2].tag = index, "summary", "summary"
        depth += {"list_item_open": 1, "list_item_close": -1}.get(token.type, 0)
        outermost = depth == (1 if token.type == "list_item_open" else 0)
        if token.type in ("paragraph_open", "list_item_open") and outermost:
            number += 1
            anchors[section, number] = anchor(section, number)
            token.attrSet("id", anchors[section, number])
        _number(token.children or [], controls)
    if folded is not None:
        tokens.insert(folded, Token("html_block", "", 0, content="<details>\n"))
        tokens.append(Token("html_block", "", 0, content="</details>\n"))
    html = markdown.renderer.render(tokens, markdown.options, {})
    return Rendered(html, anchors, tuple(controls), headings, language)


def _number(tokens: list[Token], controls: dict[str, int]) -> None:
    """Make the controls that a paragraph names bold, each with its number in the order of the text."""
    named = False
    for token in tokens:
        if token.type == "link_open" and str(token.attrGet("href")).startswith(CONTROL):
            name = str(token.attrGet("href")).removeprefix(CONTROL)
            number = controls.setdefault(name, len(controls) + 1)
            token.tag, token.attrs, named = "b", {"class": "control", "data-number": number}, True
        elif token.type == "link_close" and named:
            token.tag, named = "b", False


@dataclass(frozen=True)
class Place:
    """A control in a picture: its number in the text and its rectangle (px)."""

    number: int
    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True)
class Shape:
    """The pictures of one width of the page, light and dark, with their size (px) and the controls in them.

    `look` is the beginning of their names in addresses: the width, after the language if that is not English.
    """

    name: str
    look: str
    width: int
    height: int
    places: tuple[Place, ...]


@cache
def shapes(driver: str, controls: tuple[str, ...], language: str = ENGLISH) -> tuple[Shape, ...]:
    """Return the pictures of a robot's orientation, for wide and for narrow pages; none if its package has none.

    They show the page in the language, or in English where the package has no pictures in it.
    """
    try:
        found: dict[str, Any] = json.loads(description.text_of(driver, f"{folder_of(language)}/{PLACES}"))
    except (OSError, ImportError):
        return () if language == ENGLISH else shapes(driver, controls)
    before = "" if language == ENGLISH else f"{language}-"
    return tuple(
        Shape(name, f"{before}{name}", one["size"][0], one["size"][1], tuple(
            Place(number, *one["places"][control])
            for number, control in enumerate(controls, 1) if control in one["places"]
        ))
        for name, one in found.items()
    )  # fmt: skip


def picture(driver: str, look: str) -> bytes:
    """Return a picture (WebP) of a robot's orientation. Raises LookupError, OSError or ImportError."""
    parts = LOOK.fullmatch(look)
    if parts is None:
        raise LookupError(look)
    return description.folder(driver).joinpath(folder_of(parts[1] or ENGLISH), f"{parts[2]}.webp").read_bytes()


def folder_of(language: str) -> str:
    """Return the folder of the pictures in a language, beside the texts."""
    return FOLDER if language == ENGLISH else f"{FOLDER}.{language}"
