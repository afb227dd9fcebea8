"""Every room asks the clock that it is given, or `SYSTEM`, or its event loop; so tests decide how time passes."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("robots", "accounts", "queueing", "operatorlog", "portal", "workers", "simulators")
STAY = {  # a file that has to ask the machine itself, and why
    "robots/clock.py": "it is the machine's clock",
    "robots/priority.py": "it waits for the kernel, which counts its own tenth of a second",
    "portal/forks.py": "a process that was forked a moment ago, before anything of ours is loaded",
    "portal/logs/lines.py": "the logging module stamps records by the machine's clock, and has it formatted",
    "workers/cameras/source.py": "its thread reads what a real camera sends, as it comes",
    "workers/cameras/response.py": "it limits what a real server may send, by the timeouts of its socket",
}
APART = "robots/drivers/irat/ros"  # runs on the robot's computer, where there is no clock of ours
NOW = {"now", "utcnow", "today"}


def asked(tree):
    """Return the lines that ask the machine's clock: the module `time`, or `datetime` for now."""
    lines = []
    for node in ast.walk(tree):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        of_time = "time" in names or (isinstance(node, ast.ImportFrom) and node.module == "time")
        of_now = isinstance(node, ast.Attribute) and node.attr in NOW and "date" in ast.unparse(node.value)
        if of_time or of_now:
            lines.append(node.lineno)
    return sorted(lines)


def test_no_room_asks_the_machines_clock():
    files = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]
    files = [path for path in files if not path.is_relative_to(ROOT / APART)]
    files = [path for path in files if "migrations" not in path.parts]
    assert len(files) > 400
    found = {str(path.relative_to(ROOT)): asked(ast.parse(path.read_text())) for path in files}
    assert {name: lines for name, lines in found.items() if lines and name not in STAY} == {}
    assert [name for name in STAY if not found.get(name)] == [], "a reason that is no longer needed"


@pytest.mark.parametrize(
    "line",
    [
        "import time",
        "import json, time as t",
        "from time import monotonic",
        "at = datetime.now(UTC)",
        "datetime.date.today()",
    ],
)
def test_what_asks_it_would_be_found(line):
    assert asked(ast.parse(f"x = 1\n{line}\n")) == [2]
