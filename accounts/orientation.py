"""Renders the orientation with an anchor for each paragraph, so that the test can refer to it."""

import re
from dataclasses import dataclass

from markdown_it import MarkdownIt


@dataclass(frozen=True)
class Rendered:
    """The orientation's HTML, and the anchor of each paragraph by section and number, from 1."""

    html: str
    anchors: dict[tuple[str, int], str]


def anchor(section: str, paragraph: int) -> str:
    """Return the anchor of a paragraph or list item on the page."""
    return f"{re.sub(r'[^a-z0-9]+', '-', section.lower()).strip('-')}-{paragraph}"


def render(source: str) -> Rendered:
    """Render Markdown; HTML in it is escaped. List items count as paragraphs."""
    markdown = MarkdownIt("commonmark", {"html": False})
    tokens = markdown.parse(source)
    anchors: dict[tuple[str, int], str] = {}
    section, number, depth = "", 0, 0
    for index, token in enumerate(tokens):
        if token.type == "heading_open":
            section, number = tokens[index + 1].content, 0
        depth += {"list_item_open": 1, "list_item_close": -1}.get(token.type, 0)
        outermost = depth == (1 if token.type == "list_item_open" else 0)
        if token.type in ("paragraph_open", "list_item_open") and outermost:
            number += 1
            anchors[section, number] = anchor(section, number)
            token.attrSet("id", anchors[section, number])
    return Rendered(markdown.renderer.render(tokens, markdown.options, {}), anchors)
