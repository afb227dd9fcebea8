"""A robot from a package of its own: nothing generic knows of it, and the portal finds it as it is."""

import re
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from portal.web.consoles.console import console_of
from portal.web.consoles.files import Finder

ROOT = Path(__file__).resolve().parents[2]
GENERIC = (
    "accounts", "queueing", "operatorlog", "portal", "robots", "workers", "simulators", "templates", "frontend/src",
    "Makefile", "pyproject.toml", "frontend/vite.config.ts", "frontend/tsconfig.json",
)  # fmt: skip
ITS_WORDS = re.compile(r"turntable|\bdial\b", re.IGNORECASE)


def files():
    for name in GENERIC:
        path = ROOT / name
        yield from (p for p in path.rglob("*") if p.is_file()) if path.is_dir() else (path,)


def test_no_generic_file_knows_a_word_of_the_package():
    looked_at = 0
    for path in files():
        if "__pycache__" in path.parts:  # its files come and go
            continue
        looked_at += 1
        found = ITS_WORDS.search(path.read_text("utf-8", errors="replace"))
        assert found is None, f"{path.relative_to(ROOT)} says {found and found[0]!r}"
    assert looked_at > 200


def test_its_console_is_found_where_the_package_is_installed(installed):
    assert entry_points(group="farhand.drivers", name="turntable")
    console = console_of("turntable")
    assert (console.module, console.style) == (
        "/static/robots/turntable/console.js",
        "/static/robots/turntable/console.css",
    )
    assert console.built == ""
    served = {path for path, storage in Finder().list(None) if storage.prefix == "robots/turntable"}
    assert served == {"console.js", "console.css"}, "neither templates nor Python"
    assert Finder().find("robots/turntable/console.js").endswith("turntable_robot/console/console.js")


@pytest.mark.parametrize("path", ["console.html", "../driver.py", "../../turntable_robot/driver.py", "nothing.js", ""])
def test_nothing_else_of_the_package_is_served(installed, path):
    assert Finder().find(f"robots/turntable/{path}") == []


def test_a_package_without_a_script_gets_the_console_that_its_spec_draws(monkeypatch, tmp_path):
    from tests.packaged import installed_from, without_console

    with installed_from(without_console(tmp_path / "bare"), monkeypatch):
        assert console_of("turntable").console == "consoles/plain.html"
