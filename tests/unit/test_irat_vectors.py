"""The iRat's byte streams are packed as the browser reads them (frontend/tests/irat_streams.test.ts)."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from robots.kit.drivers.irat.brain.streams import UNIT_M, CellStream, MapStream
from robots.kit.slam.stream import Changes

FILE = Path(__file__).resolve().parents[1] / "vectors" / "irat_streams.json"
VECTORS = json.loads(FILE.read_text()) if FILE.exists() else {"map": [], "cells": []}


def map_packets(told):
    """Return what the stream sends for a map that changes so, and what is on it at the end."""
    stream, packets, spots, links = MapStream(), [], {}, []
    for one in told:
        poses = np.array([[*at, 0.0] for at in one["poses"]]).reshape(-1, 3)
        ids, pairs = np.array(one["ids"], np.int64), np.array(one["links"], np.int64).reshape(-1, 2)
        changes = Changes(one["map"], one["sequence"], one["whole"], ids, poses, pairs)
        slam = SimpleNamespace(
            map_number=one["map"], sequence=one["sequence"], since=lambda _, found=changes: found,
            docks=SimpleNamespace(places=dict.fromkeys(one["docks"])),
        )  # fmt: skip
        data, key = stream.next(slam, tuple(one["route"]), one.get("dock"), 0.42)
        packets.append({"hex": data.hex(), "key": key})
        if one["whole"]:
            spots, links = {}, []
        kept = np.clip(np.rint(poses[:, :2] / UNIT_M), -32768, 32767)
        spots |= {str(i): [float(v) * UNIT_M for v in at] for i, at in zip(one["ids"], kept, strict=True)}
        links = links + one["links"]
    last, dock = told[-1], told[-1].get("dock_shown")
    return packets, {
        "number": last["map"], "spots": spots, "links": links, "route": last["route"], "docks": sorted(last["docks"]),
        "dock": dock,
    }  # fmt: skip


def cell_packets(told):
    """Return what the stream sends for cells that are so active, and their levels at the end where they are not 0."""
    stream, packets = CellStream(), []
    cells = np.zeros((36, 15, 15))
    for one in told:
        cells[:] = 0.0
        for number, value in one.items():
            cells.reshape(-1)[int(number)] = value
        data, key = stream.next(cells)
        packets.append({"hex": data.hex(), "key": key})
    most = max([*told[-1].values(), 1e-300])
    return packets, {number: round(value / most * 7) for number, value in told[-1].items() if round(value / most * 7)}


@pytest.mark.parametrize("one", VECTORS["map"], ids=lambda one: one["what"])
def test_the_map(one):
    assert map_packets(one["told"]) == (one["packets"], one["shown"])


@pytest.mark.parametrize("one", VECTORS["cells"], ids=lambda one: one["what"])
def test_the_cells(one):
    assert cell_packets(one["told"]) == (one["packets"], one["shown"])


def test_there_are_vectors():
    assert len(VECTORS["map"]) > 3
    assert len(VECTORS["cells"]) > 1
