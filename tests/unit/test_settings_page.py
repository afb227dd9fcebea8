"""The page of settings names every variable that the portal reads."""

import re

from tests.environment import ROOT

READ = re.compile(r"""(?:env(?:\.\w+)?\(|environ(?:\.get\(|\[))\s*"([A-Z_]+)\"""")
OF_OTHERS = {"XDG_DATA_HOME", "OPENBLAS_NUM_THREADS"}  # of the system and of a library, with their meaning there
ROOMS = ("portal", "accounts", "queueing", "operatorlog", "robots", "workers")


def test_every_variable_that_is_read_is_on_the_page():
    page = (ROOT / "docs" / "reference" / "settings.md").read_text("utf-8")
    files = [file for room in ROOMS for file in (ROOT / room).rglob("*.py")]
    read = {name for file in files for name in READ.findall(file.read_text("utf-8"))}
    assert "FARHAND_VAR" in read
    assert {name for name in read if f"`{name}`" not in page} - OF_OTHERS == set()
