"""Code that serves every robot contains no word of a single one: it asks for what the robot's spec declares."""

import ast
import re
from functools import cache

import pytest

from tests.environment import ROOT
from tools.setup import prepared

ROOMS = ("robots", "workers", "portal", "queueing", "accounts", "operatorlog")
OF_ONE_ROBOT = ("robots/kit/drivers/", "robots/kit/arms/", "robots/kit/rovers/", "robots/kit/slam/", "/migrations/")
WORDS = frozenset({
    "click", "calibrate", "soft_reset", "sand", "arm", "up", "down", "air", "move", "jog", "home", "gripper", "pen",
    "stability_exposure_s", "stability_tries", "exposure_range_s", "mercury", "pa10", "puma", "turntable",
    "stability_threshold", "delivery_exposure_s", "boxes", "speed", "residual", "residual_mm", "theta",
    "irat", "ratslam", "goal", "explore", "charge", "dock", "experience", "map_cleared", "clear_map", "pruning",
})  # fmt: skip
AS_NAMES = WORDS - {
    "up",
    "down",
    "home",
    "move",
    "air",
    "arm",
    "pen",
    "click",
    "soft_reset",
    "charge",
    "exposure_range_s",
}  # plain English too
ALLOWED = {
    "robots/kit/contract/procedures.py": {"calibrate", "soft_reset"},  # the portal's own, declared once
    "robots/kit/contract/policies.py": {"speed"},  # what a bound of any robot's motion limits
    "workers/authority/gate.py": {"speed"},  # where that bound is kept
    "robots/kit/conformance/states.py": {"speed"},  # and where it is checked
    "accounts/passwords.py": {"mercury", "arm"},  # words that make a password easy to guess
    "robots/models/robot.py": {"mercury"},  # what the form of a new robot begins with
    "portal/keep/seeding.py": {"mercury", "pa10", "irat", "puma"},  # the demo's robots
}
PAGES = ("templates", "frontend/src")
OF_AN_ARM = ("frontend/src/arm/", "frontend/src/motion/", "frontend/src/scene/", "frontend/src/admin/editors/boxes.ts")
IN_PAGES = re.compile(r"\b(residual_mm|residual|theta|stability_\w+|exposure_\w+|boxes)\b")
EXPOSURE = re.compile(r"\b1 / 150\b")


def generic():
    files = [str(f.relative_to(ROOT)) for room in ROOMS for f in sorted((ROOT / room).rglob("*.py"))]
    return [f for f in files if not any(part in f for part in OF_ONE_ROBOT)]


def pages():
    files = [str(f.relative_to(ROOT)) for room in PAGES for f in sorted((ROOT / room).rglob("*.*"))]
    return [f for f in files if f.endswith((".html", ".ts")) and not f.startswith(OF_AN_ARM)]


def words_of(node):
    """Return the words of single robots in one node of the syntax: in a text, a name, an attribute, an argument."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return {node.value, *node.value.split("__")} & WORDS  # also in the path of a query
    return {getattr(node, field, None) for field in ("id", "attr", "arg", "name")} & AS_NAMES


@cache
def said(path):
    """Return the words and the modules of single robots in a file."""
    found = set()
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        found |= words_of(node)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("robots.kit.drivers."):
            found |= {node.module} - {"robots.kit.drivers.panels"}
    return found


@pytest.mark.parametrize("room", ROOMS)
def test_no_word_of_a_single_robot_stands_in_generic_code(room):
    files = [path for path in generic() if path.startswith(f"{room}/")]
    assert files
    assert {path: words for path in files if (words := said(path) - ALLOWED.get(path, set()))} == {}


def test_every_excuse_is_needed():
    assert not {path: unused for path, words in ALLOWED.items() if (unused := words - said(path))}


@pytest.mark.parametrize("room", PAGES)
def test_no_word_of_a_single_robot_stands_in_generic_pages(room):
    files = [path for path in pages() if path.startswith(f"{room}/")]
    assert files
    assert {path: words for path in files if (words := IN_PAGES.findall((ROOT / path).read_text()))} == {}


def test_no_exposure_is_invented():
    assert [path for path in generic() if EXPOSURE.search((ROOT / path).read_text())] == []


def test_set_up_names_no_robot_and_finds_what_each_one_has_compiled():
    tool = (ROOT / "tools/setup.py").read_text()
    robots = {f.name for room in ("robots/kit/drivers", "simulators") for f in (ROOT / room).iterdir() if f.is_dir()}
    assert len(robots & {"mercury", "pa10", "irat", "so101"}) == 4
    assert [word for word in robots - {"common"} if word in tool] == []
    assert [str(f.relative_to(ROOT)) for f in prepared()] == [
        "robots/kit/drivers/irat/prepare.py", "simulators/irat/prepare.py", "simulators/puma/prepare.py",
        "simulators/srv1/prepare.py",
    ]  # fmt: skip


def test_the_admin_offers_only_what_is_declared():
    page = (ROOT / "templates/admin/robots/robot/change_form.html").read_text()
    assert "calibrate" not in page.lower()
    assert "soft_reset" not in page
