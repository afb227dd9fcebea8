"""The pages for people: what they link, the commands that they name, and what they say of the tests is there."""

import re
import tomllib
from functools import cache

import pytest

from tests import waiting
from tests.environment import ROOT

PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("robots/kit/drivers/*/README.md")])
CODE = re.compile(r"^```.*?^```|`[^`\n]+`", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s#]+)(?:#([\w-]*))?\)")
MADE = re.compile(r"\bmake ([a-z][a-z-]*)")
FILES = re.compile(r"`((?:tests|tools|docs|frontend|requirements|portal|templates)/[\w./-]+)`")
OURS = ("CONTRIBUTING.md", "README.md", "docs/explanation/testing.md", "docs/explanation/proofs.md")
TESTING = (ROOT / "docs/explanation/testing.md").read_text()


def name(page):
    return str(page.relative_to(ROOT))


@cache
def targets():
    return set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_link_to_a_file_and_every_make_of_a_page_is_there(page):
    text = page.read_text()
    links = [to for to, _ in LINK.findall(CODE.sub("", text)) if ":" not in to]
    assert [to for to in links if not (page.parent / to).exists()] == []
    code = " ".join(CODE.findall(text))
    assert {target for target in MADE.findall(code) if target not in targets()} == set()


def test_every_target_of_the_makefile_can_be_called():
    phony = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert set(phony[1].split()) == targets()


@pytest.mark.parametrize("page", OURS)
def test_every_file_named_is_there(page):
    named = FILES.findall((ROOT / page).read_text())
    assert [path for path in named if not (ROOT / path).exists()] == []


def test_every_room_of_tests_is_explained():
    rooms = {f"tests/{file.parent.name}" for file in (ROOT / "tests").glob("*/test_*.py")}
    assert {room for room in rooms if f"| `{room}` |" not in TESTING} == set()


def test_what_is_said_of_the_gate_is_so():
    makefile = (ROOT / "Makefile").read_text()
    assert "It runs everything that is marked neither `timed` nor `length`" in TESTING
    assert "GATE = not timed and not length\n" in makefile
    assert [makefile.count(f'-m "$(GATE) and {which}"') for which in ("service", "not service")] == [1, 1]
    assert "marked `service` and runs on PostgreSQL, everything else on SQLite: each test once" in TESTING
    assert "Waits end after two minutes" in TESTING
    assert waiting.CEILING_S == 120
    assert "Tests with real processes are in it if they judge by order" in TESTING
    assert all(f"| `{mark}` |" in TESTING for mark in ("timed", "length", "service"))
    marks = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["pytest"]["ini_options"]["markers"]
    assert {"timed", "length", "service"} <= {mark.partition(":")[0] for mark in marks}


def test_nothing_runs_a_test_again():
    assert "It is never run again until it passes, and no plug-in does that here." in TESTING
    wanted = (ROOT / "requirements/test.in").read_text() + (ROOT / "Makefile").read_text()
    assert re.findall(r"rerun|flaky|retry", wanted) == []


def test_continuous_integration_runs_what_is_said():
    assert "`make check`, then `make test`" in (ROOT / "CONTRIBUTING.md").read_text()
    assert (ROOT / ".ci/run").read_text().splitlines()[-2:] == ["make check", "make test"]
