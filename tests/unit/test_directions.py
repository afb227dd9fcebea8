"""Style sheets say start and end, not left and right, so that pages can be read from right to left."""

import re

import pytest

from tests.environment import ROOT

ROOMS = ("frontend/src", "portal", "robots", "simulators", "templates", "tests/packages")
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
DECLARATION = re.compile(r"(?<=[{;])\s*([\w-]+)\s*:\s*([^;{}]+?)\s*(?=[;}])")
SIDE = re.compile(r"(?<![a-z])(left|right)(?![a-z])")
OF_FOUR_SIDES = re.compile(r"(scroll-)?(margin|padding)|inset|border-(width|style|color)")
PART = re.compile(r"(?:[^\s(]|\((?:[^()]|\([^()]*\))*\))+")
# where a side is meant, by the property that names it
ALLOWED = {
    "--safe-start": "the screen's own edges have no other names; the other files use this",
    "--safe-end": "as --safe-start",
}


def uneven(name, value):
    """Tell whether a value of several parts has another left than right."""
    parts = PART.findall(value)
    if OF_FOUR_SIDES.fullmatch(name):
        return len(parts) == 4 and parts[1] != parts[3]
    if name == "border-radius" and "/" not in value and 2 <= len(parts) <= 4:
        top_left, top_right, bottom_right, bottom_left = (*parts, *parts, parts[1])[:4]
        return (top_left, bottom_left) != (top_right, bottom_right)
    return False


def physical(sheet):
    """Return the declarations of a style sheet that mean a left or a right."""
    found = DECLARATION.findall(COMMENT.sub("", sheet))
    return [
        f"{name}: {value}"
        for name, value in found
        if name not in ALLOWED and (SIDE.search(name) or SIDE.search(value) or uneven(name, value))
    ]


def test_no_style_sheet_names_left_or_right():
    sheets = [file for room in ROOMS for file in (ROOT / room).rglob("*.css") if "node_modules" not in file.parts]
    assert len(sheets) > 20
    found = {str(file.relative_to(ROOT)): physical(file.read_text()) for file in sheets}
    assert {name: wrong for name, wrong in found.items() if wrong} == {}


@pytest.mark.parametrize(
    "wrong",
    [
        "margin-left: 1px",
        "left: 0",
        "border-top-left-radius: 2px",
        "border-right: 0",
        "scroll-padding-right: 1px",
        "float: right",
        "text-align: left",
        "background: url(a.svg) right 2px no-repeat",
        "margin: 0 0 0 1px",
        "inset: auto 1rem calc(100% + (2 * 3px)) auto",
        "padding: 0 env(safe-area-inset-right) 0 env(safe-area-inset-left)",
        "padding-inline-start: env(safe-area-inset-left)",
        "border-radius: 1px 0 0 1px",
        "border-radius: 0 1px",
        "border-color: red blue red green",
    ],
)
def test_it_finds_what_means_a_side(wrong):
    assert physical(f"a:hover {{ color: red; {wrong}; top: 0 }}") == [wrong]
    assert physical(f"@media (min-width: 9px) {{ a {{ {wrong} }} }}") == [wrong]


@pytest.mark.parametrize(
    "right",
    [
        "margin: 0 1px",
        "margin: 0 auto 2px",
        "inset: auto 0 calc(100% + 2px) 0",
        "inset-inline: 0 auto",
        "float: inline-end",
        "text-align: start",
        "border-radius: 1px 1px 0 0",
        "border-radius: 50% / 10%",
        "grid-area: 1 / 1 / 2 / 3",
        "background: url(bright.svg)",
    ],
)
def test_it_leaves_the_rest(right):
    assert physical(f"a {{ {right}; }} /* left: 0 */") == []
