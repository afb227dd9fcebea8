"""Consoles of the robots that ship with Farhand: found in their folders, with buttons for what the robots can do."""

import re

import pytest

from portal.web.consoles.console import PARTS, PLAIN, console_of, parts
from robots.kit.contract.find import spec_of
from robots.kit.contract.spec import STAFF, TURN
from tests.environment import ROOT

DRAWN = sorted(p.parent.parent.name for p in (ROOT / "robots/kit/drivers").glob("*/console/console.ts"))


def whole(page):
    """Return the text of a page, with what it includes: of all consoles, or of the robot's own folder."""

    def part(found):
        shared = ROOT / "templates" / found[1]
        return whole(shared if shared.is_file() else page.parent / shared.name)

    return re.sub(r'{% include "([^"]+)"[^%]*%}', part, page.read_text())


def test_robots_with_a_console_are_found():
    assert {"mercury", "pa10", "irat"} <= set(DRAWN)
    assert console_of("so101") == PLAIN


@pytest.mark.parametrize("driver", DRAWN)
def test_every_button_of_a_command_names_one_that_an_operator_or_staff_may_give(driver):
    console = console_of(driver)
    assert (ROOT / "frontend" / console.built).resolve().is_file()
    page = whole(ROOT / "robots/kit/drivers" / driver / "console" / "console.html")
    named = set(re.findall(r'data-kind="([^"]+)"', page))
    assert named, "a button without the name of its command would be offered whatever the robot can do"
    assert named <= {c.kind for c in spec_of(driver).commands if c.open_to(TURN) or c.open_to(STAFF)}


@pytest.mark.parametrize("driver", DRAWN)
def test_stop_and_release_are_the_pages(driver):
    page = (ROOT / "robots/kit/drivers" / driver / "console" / "console.html").read_text()
    assert page.startswith('{% extends "consoles/frame.html" %}')
    frame = (ROOT / "templates/consoles/frame.html").read_text()
    assert 'data-command="stop"' not in page + frame
    stage = (ROOT / "templates/consoles/stage.html").read_text()
    assert stage.count('data-command="stop"') == 1
    assert "{% block " not in stage, "a console can replace nothing of it"


def test_a_console_is_cut_into_its_parts():
    text = "|look|plain|screen|<p>\n|buttons||beside||body|<b>|".removesuffix("|")
    empty = dict.fromkeys(PARTS, "")
    assert parts(text, "|") == empty | {"look": "plain", "screen": "<p>", "body": "<b>"}
    assert parts(" all of it ", "|") == empty | {"body": "all of it"}


def test_one_function_alone_switches_controls_off():
    """A control that only looks switched off would not say why."""
    sources = [*(ROOT / "frontend/src").rglob("*.ts"), *(ROOT / "robots/kit/drivers").glob("*/console/*.ts")]
    found = [p.name for p in sources if re.search(r'"aria-disabled"\s*[:,]', p.read_text())]
    assert found == ["refusal.ts"]


def test_what_is_published_is_described():
    page = (ROOT / "docs/reference/console-module.md").read_text()
    told = set(re.findall(r"\w+", " ".join(re.findall(r"^\|.*?\|.*?\|", page, re.MULTILINE))))
    for module in sorted((ROOT / "frontend/src/v1").glob("*.ts")):
        exported = ", ".join(re.findall(r"^export \{(.*?)\}", module.read_text(), re.MULTILINE)).split(",")
        names = {name.strip().rpartition(" as ")[2] for name in exported if not name.strip().startswith("type ")}
        assert names - {""}, module.name
        assert f"{module.stem}.js" in page
        assert names - {""} <= told, module.name
