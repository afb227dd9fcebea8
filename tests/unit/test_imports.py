"""The import graphs of Python and of TypeScript: no circle of files.

import-linter has a contract for circles of packages that lie side by side, and none for circles of files.
"""

import re
from pathlib import Path

import grimp
import networkx
import pytest

PACKAGES = ("accounts", "operatorlog", "portal", "queueing", "robots", "simulators", "tests", "workers")
ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ("frontend", "robots", "tests/packages")
# each form of importing a file of ours: import .. from, export .. from, import "..", import("..")
IMPORTED = re.compile(r"""(?:\bfrom|\bimport)\s*\(?\s*["'](\.[^"']+)["']""")


def circles(edges):
    """Return the sets of modules that import one another, from {module: what it imports}."""
    parts = networkx.strongly_connected_components(networkx.DiGraph(edges))
    return sorted(sorted(part) for part in parts if len(part) > 1)


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


def scripts():
    """Return {file: what it imports} of our TypeScript; imports of types count, too."""
    files = {
        path
        for room in SCRIPTS
        for path in (ROOT / room).rglob("*.ts")
        if "node_modules" not in path.parts and "dist" not in path.parts
    }
    return {path: imported(path, path.read_text()) for path in files}


def imported(path, text):
    """Return the files that a script imports."""
    found = {(path.parent / name.partition("?")[0]).resolve() for name in IMPORTED.findall(text)}
    return {file if file.suffix == ".ts" else file.with_suffix(".ts") for file in found if file.suffix in ("", ".ts")}


def test_no_circle_of_scripts():
    edges = scripts()
    assert len(edges) > 80
    assert sum(map(len, edges.values())) > 200
    assert [[str(file.relative_to(ROOT)) for file in circle] for circle in circles(edges)] == []


@pytest.mark.parametrize(
    "line",
    [
        'import type { A } from "./b.ts";',
        'export { A } from "./b.ts";',
        'import "./b.ts";',
        'const b = await import("./b.ts");',
        'import {\n  A,\n} from "./b.ts";',
    ],
)
def test_a_circle_of_scripts_would_be_found(line):
    here = ROOT / "a.ts"
    assert imported(here, line) == {ROOT / "b.ts"}
    assert circles({here: imported(here, line), ROOT / "b.ts": {here}}) == [[here, ROOT / "b.ts"]]


def test_the_clock_of_states_is_converted_in_one_place():
    """`RobotState.at` is on the drivers' clock; elsewhere it would be compared with another clock."""
    rooms = [path for room in ("workers", "portal", "queueing", "operatorlog") for path in (ROOT / room).rglob("*.py")]
    readers = [path for path in rooms if re.search(r"\b(state|heard|latest\(\))\.at\b", path.read_text())]
    assert [str(path.relative_to(ROOT)) for path in readers] == ["workers/owned.py"]
