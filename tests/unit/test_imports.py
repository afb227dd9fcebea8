"""The import graphs of Python and of TypeScript: no circle of files, and consoles import what is published.

import-linter has a contract for circles of packages that lie side by side, and none for circles of files. TypeScript's
compiler has no rule for who may import what, and another linter's would be one more dependency.
"""

import re

import grimp
import networkx
import pytest

from tests.environment import ROOT

PACKAGES = ("accounts", "operatorlog", "portal", "queueing", "robots", "simulators", "tests", "workers")
SCRIPTS = ("frontend", "robots", "tests/packages")
# each form of importing: import .. from, export .. from, import "..", import(".."), and @import ".." of a style
IMPORTED = re.compile(r"""(?:\bfrom|\bimport)\s*\(?\s*(?:url\()?["'`]([^"'`\s]+)["'`]""")
PUBLISHED = re.compile(r"/static/farhand/(v1/\w+)\.js")  # the one alias: tsconfig.json and vite.config.ts have it, too


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
    edges["workers.authority.memory"] = {"workers.process.wiring"}
    assert any("workers.authority.memory" in circle for circle in circles(edges))


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
    """Return the files of ours that a script imports."""
    names = [PUBLISHED.sub(rf"{ROOT}/frontend/src/\1.ts", name) for name in IMPORTED.findall(text)]
    ours = [name.partition("?")[0] for name in names if name.startswith((".", "/"))]
    found = {(path.parent / name).resolve() for name in ours}
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


def test_the_published_module_is_a_part_of_the_graph():
    line = 'import { RobotPage } from "/static/farhand/v1/console.js";'
    assert imported(ROOT / "a.ts", line) == {ROOT / "frontend/src/v1/console.ts"}
    edges = scripts()
    assert ROOT / "frontend/src/page/robot_page.ts" in edges[ROOT / "frontend/src/v1/console.ts"]


def consoles():
    """Return the scripts and styles of the consoles that ship with Farhand."""
    files = (ROOT / "robots/kit/drivers").glob("*/console/**/*")
    return [path for path in files if path.suffix in (".ts", ".js", ".css")]


def unpublished(path, text):
    """Return what a console's file imports that is neither in its folder nor published, or names of the front end."""
    folder = next(parent for parent in path.parents if parent.name == "console")
    found = re.findall(r"\bimport\s*\(\s*[^\s\"'`][^)]*|frontend/", text)  # an import that is made up, or another way
    for name in IMPORTED.findall(text):
        known = PUBLISHED.fullmatch(name)
        own = name.startswith("./") and (path.parent / name).resolve().is_relative_to(folder)
        if not own and not (known and (ROOT / f"frontend/src/{known[1]}.ts").is_file()):
            found.append(name)
    return found


def test_shipped_consoles_import_only_their_own_files_and_the_published_module():
    files = consoles()
    assert {"console.ts", "console.css"} <= {path.name for path in files}
    assert [
        (str(path.relative_to(ROOT)), wrong) for path in files if (wrong := unpublished(path, path.read_text()))
    ] == []


@pytest.mark.parametrize(
    "line",
    [
        'import { allow } from "../../../../frontend/src/kit/refusal.ts";',
        'import type { Facts } from "/static/farhand/../../frontend/src/page/controls.ts";',
        'import "../../mercury/console/console.css";',
        'import { x } from "./../driver.ts";',
        'export { numeral } from "../../pa10/console/program_text.ts";',
        'const { ArmView } = await import("../../../../frontend/src/arm/view.ts");',
        "const { ArmView } = await import(`/src/arm/view.ts`);",
        "const view = await import(address);",
        'const all = import.meta.glob("../../../../frontend/src/*.ts");',
        'import { allow } from "/static/farhand/v1/nothing.js";',
        'import { allow } from "/static/farhand/v1/console.ts";',
        'import { Scene } from "three";',
        '@import url("../../../../frontend/src/arm/arm.css");',
    ],
)
def test_another_import_of_a_console_would_be_found(line):
    assert unpublished(ROOT / "robots/kit/drivers/irat/console/console.ts", line)


def test_the_clock_of_states_is_converted_in_one_place():
    """`RobotState.at` is on the drivers' clock; elsewhere it would be compared with another clock."""
    rooms = [path for room in ("workers", "portal", "queueing", "operatorlog") for path in (ROOT / room).rglob("*.py")]
    readers = [path for path in rooms if re.search(r"\b(state|heard|latest\(\))\.at\b", path.read_text())]
    assert [str(path.relative_to(ROOT)) for path in readers] == ["workers/robot/owned.py"]
