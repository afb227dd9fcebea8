"""Rooms that serve every robot know none of the words of one: they ask for what its spec declares."""

import ast
from pathlib import Path

import pytest

from tools.setup import prepared

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("robots", "workers", "portal", "queueing", "accounts", "operatorlog")
OF_ONE_ROBOT = ("robots/drivers/", "robots/motion/", "robots/autonomy/", "/migrations/")
WORDS = frozenset({
    "click", "calibrate", "soft_reset", "sand", "arm", "up", "down", "air", "move", "jog", "home", "gripper", "pen",
    "stability_exposure_s", "stability_tries", "exposure_range_s", "mercury", "pa10", "turntable",
    "irat", "ratslam", "goal", "explore", "charge", "dock", "experience", "map_cleared", "clear_map", "pruning",
})  # fmt: skip
ALLOWED = {
    "robots/contract/procedures.py": {"calibrate", "soft_reset"},  # the portal's own, declared once
    "robots/contract/capabilities.py": {"stability_exposure_s", "stability_tries", "exposure_range_s"},
    "accounts/passwords.py": {"mercury", "arm"},  # words that make a password easy to guess
    "robots/models.py": {"mercury"},  # what the form of a new robot begins with
    "robots/description.py": {"arm"},  # the table of robot.toml that any serial arm has
    "portal/seeding.py": {"mercury", "pa10", "irat"},  # the demo's robots
    "portal/settings.py": {"mercury", "pa10"},
}


def generic():
    files = [str(f.relative_to(ROOT)) for room in ROOMS for f in sorted((ROOT / room).rglob("*.py"))]
    return [f for f in files if not any(part in f for part in OF_ONE_ROBOT)]


def said(path):
    """Return the words and the modules of single robots in a file."""
    found = set()
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found |= {node.value} & WORDS
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("robots.drivers."):
            found |= {node.module} - {"robots.drivers.errors", "robots.drivers.panels"}
    return found


@pytest.mark.parametrize("path", generic())
def test_no_word_of_a_single_robot_stands_in_generic_code(path):
    assert said(path) - ALLOWED.get(path, set()) == set()


def test_set_up_names_no_robot_and_finds_what_each_one_has_compiled():
    tool = (ROOT / "tools/setup.py").read_text()
    robots = {f.name for room in ("robots/drivers", "simulators") for f in (ROOT / room).iterdir() if f.is_dir()}
    assert len(robots & {"mercury", "pa10", "irat", "so101"}) == 4
    assert [word for word in robots - {"common"} if word in tool] == []
    assert [str(f.relative_to(ROOT)) for f in prepared()] == [
        "robots/drivers/irat/prepare.py", "simulators/irat/prepare.py",
    ]  # fmt: skip


def test_the_admin_offers_only_what_is_declared():
    page = (ROOT / "templates/admin/robots/robot/change_form.html").read_text()
    assert "calibrate" not in page.lower()
    assert "soft_reset" not in page
