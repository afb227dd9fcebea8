"""The import graph: no circle of files in our packages, and no module imports the owner's wiring."""

import re
from pathlib import Path

import grimp
import pytest

PACKAGES = ("accounts", "operatorlog", "portal", "queueing", "robots", "simulators", "workers")
ROOT = Path(__file__).resolve().parents[2]
WIRED_BY = {"workers.bootstep"}


def circles(edges):
    """Return the sets of modules that import one another, from {module: what it imports} (Tarjan's algorithm)."""
    number, low, stack, found = {}, {}, [], []

    def visit(module):
        number[module] = low[module] = len(number)
        stack.append(module)
        for other in edges.get(module, ()):
            if other not in number:
                visit(other)
            if other in stack:
                low[module] = min(low[module], low[other])
        if low[module] == number[module]:
            circle = [stack.pop()]
            while circle[-1] != module:
                circle.append(stack.pop())
            if len(circle) > 1:
                found.append(sorted(circle))

    for module in edges:
        if module not in number:
            visit(module)
    return found


@pytest.fixture(scope="module")
def graph():
    return grimp.build_graph(*PACKAGES, cache_dir=None)


def edges_of(graph):
    return {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}


def test_no_circle_of_files(graph):
    assert circles(edges_of(graph)) == []


def test_a_circle_would_be_found(graph):
    edges = edges_of(graph)
    edges["workers.safety.memory"] = {"workers.wiring"}
    assert any("workers.safety.memory" in circle for circle in circles(edges))


def test_nobody_imports_the_wiring(graph):
    """Imports for type checkers count, too."""
    assert graph.find_modules_that_directly_import("workers.wiring") == WIRED_BY


def test_the_clock_of_states_is_converted_in_one_place():
    """`RobotState.at` is on the drivers' clock; elsewhere it would be compared with another clock."""
    rooms = [path for room in ("workers", "portal", "queueing", "operatorlog") for path in (ROOT / room).rglob("*.py")]
    readers = [path for path in rooms if re.search(r"\b(state|heard|latest\(\))\.at\b", path.read_text())]
    assert [str(path.relative_to(ROOT)) for path in readers] == ["workers/owned.py"]
