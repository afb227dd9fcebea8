"""The page on the architecture says what the code's imports say."""

import re
import tomllib

import grimp
import pytest

from tests.environment import ROOT

PAGE = (ROOT / "docs/explanation/architecture.md").read_text()
ROOMS = ("accounts", "operatorlog", "portal", "queueing", "robots", "simulators", "workers")
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]


def table(head):
    """Return the rows of the table whose first cell is that: the names in code of each cell."""
    body = re.search(rf"^\| {re.escape(head)} \|.*\n\|[-|]+\|\n((?:\|.*\n)+)", PAGE, re.MULTILINE)[1]
    return [[re.findall(r"`([\w/]+)`", cell) for cell in row.strip("|").split("|")] for row in body.splitlines()]


def test_each_room_imports_what_the_page_says():
    graph = grimp.build_graph(*ROOMS, cache_dir=None)
    found = {
        room: {
            other
            for other in ROOMS
            if other != room and graph.direct_import_exists(importer=room, imported=other, as_packages=True)
        }
        for room in ROOMS
    }
    assert {names[0]: set(imports) for names, _, imports in table("room")} == found


@pytest.mark.parametrize("room", ["robots", "workers", "portal"])
def test_its_layers_are_those_of_the_import_contract(room):
    layers = next(c["layers"] for c in CONTRACTS if c["type"] == "layers" and c.get("containers") == [room])
    order = {name: depth for depth, layer in enumerate(layers) for name in layer.split(" | ")}
    shown = [names for names, _ in table(f"`{room}`, from the top")]
    depths = [{order[name] for name in names} for names in shown]
    assert all(len(depth) == 1 for depth in depths), "names in one row lie in one layer"
    assert [*depths] == sorted(depths, key=min)
    folders = {f.parent.name for f in (ROOT / room).glob("*/__init__.py")} - {
        "migrations",
        "templatetags",
        "management",
    }
    assert folders <= {name for names in shown for name in names} | {"logs", "postgres"}


def test_the_kit_s_folders_are_all_there():
    shown = {name for names, _ in table("`robots/kit`") for name in names}
    folders = {f.parent.name for f in (ROOT / "robots/kit").glob("*/__init__.py")}
    assert folders <= shown
    assert all(list((ROOT / "robots/kit").glob(f"{name}*")) for name in shown)


def test_every_place_that_it_names_is_there():
    places = [name for names in re.findall(r"`([\w/]+/[\w/]+)`", PAGE) for name in [names]]
    assert places
    assert [name for name in places if not (ROOT / name).exists() and not (ROOT / f"{name}.py").exists()] == []
