"""Saves a map so that the robot can go on exactly where it was, and reads it after a crash.

Templates are the largest part and never change, so they have a file of their own, to which new ones are appended. The
map's file names that file and the number of its templates; it is replaced as a whole, after the templates are on the
disk. When pruning or clearing numbers the templates anew, they begin another file.
"""

import io
import json
import os
import zipfile
import zlib
from dataclasses import asdict, astuple
from pathlib import Path
from typing import Any

import numpy as np

from robots.kit.files import replaced
from robots.kit.slam.calibration import Calibration
from robots.kit.slam.docks import DockPlace
from robots.kit.slam.experiences import LINKS, NODES, Doubt
from robots.kit.slam.settings import Settings
from robots.kit.slam.slam import RatSlam

FORMAT = 2
OF_VIEWS = ("decay", "places")
OF_LOG = ("poses", "nodes_at", "links_at")
OF_GRAPH = ("current", "next_id", "arrivals", "since", "seconds", "still")


class BadMap(ValueError):
    """The file is no map of this system, or one of other settings; the sentence says which."""


def save(slam: RatSlam, path: Path) -> None:
    """Replace the file by the map, at once or not at all. Raises OSError."""
    graph, views, log = slam.map, slam.views, slam.change_log
    _append(slam, _beside(path, views.mark))
    arrays: dict[str, Any] = {"cells": slam.cells.cells}
    arrays |= {f"view_{name}": getattr(views, name)[: views.count] for name in OF_VIEWS}
    arrays |= {f"node_{name}": getattr(graph, name)[: graph.count] for name, _, _ in NODES}
    arrays |= {f"link_{name}": getattr(graph, name)[: graph.linked] for name, _, _ in LINKS}
    arrays |= {f"told_{name}": getattr(log, name) for name in OF_LOG}
    arrays["heirs"] = np.array(list(slam.heirs.items()), np.int64).reshape(-1, 2)
    rest = {
        "format": FORMAT,
        "settings": asdict(slam.settings),
        "map_number": slam.map_number,
        "sequence": slam.sequence,
        "keep": sorted(slam.keep),
        "docks": {number: asdict(place) for number, place in slam.docks.places.items()},
        "views": {"mark": views.mark, "sum": zlib.crc32(views.templates[: views.count].tobytes())},
        "odometry": asdict(slam.odometry),
        "view": slam.view,
        "last": slam.last.hex(),
        "pruned_at": slam.pruned_at,
        "best": slam.cells.best,
        "whole_since": log.whole_since,
        "doubts": [astuple(doubt) for doubt in graph.doubts],
        **{name: getattr(graph, name) for name in OF_GRAPH},
    }
    arrays["rest"] = np.frombuffer(json.dumps(rest).encode(), np.uint8)
    with replaced(path, sync=True) as out:
        np.savez(out, **arrays)
    for other in path.parent.glob(f"{path.stem}-*.views"):
        if other != _beside(path, views.mark):
            other.unlink(missing_ok=True)


def _beside(path: Path, mark: str) -> Path:
    """Return the path of the templates' file."""
    return path.with_name(f"{path.stem}-{mark}.views")


def _append(slam: RatSlam, path: Path) -> None:
    """Write the templates that the file does not have yet."""
    views = slam.views
    begin = views.stored_count if path.exists() else 0
    if path.exists() and begin == views.count:
        return
    with path.open("r+b" if path.exists() else "wb") as out:
        out.seek(begin * views.templates[0].size)
        out.write(views.templates[begin : views.count].tobytes())
        out.truncate()  # the rest of a crash; not earlier, because the map's file relies on the templates before it
        out.flush()
        os.fsync(out.fileno())
    views.stored_count = views.count


def load(path: Path, settings: Settings | None = None) -> RatSlam:
    """Return the saved map. Raises FileNotFoundError, or BadMap for a file that is not one with these settings."""
    content = io.BytesIO(path.read_bytes())
    try:
        with np.load(content, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        rest = json.loads(arrays["rest"].tobytes())
        slam = RatSlam(settings, int(rest["map_number"]))
        if rest["format"] != FORMAT or rest["settings"] != json.loads(json.dumps(asdict(slam.settings))):
            raise BadMap(f"{path.name} is a map of another version or with other settings; it cannot be used.")
        _read_templates(slam, path, len(arrays["view_decay"]), rest["views"])
        _fill(slam, arrays, rest)
    except BadMap:
        raise
    except (KeyError, ValueError, TypeError, IndexError, EOFError, OSError, zipfile.BadZipFile) as error:
        raise BadMap(f"{path.name} is damaged and cannot be used: {error}.") from error
    return slam


def _read_templates(slam: RatSlam, path: Path, count: int, named: dict[str, Any]) -> None:
    """Take the templates from their own file."""
    mark, shape = str(named["mark"]), slam.views.templates[0].shape
    if not mark.isalnum():
        raise ValueError("the name of its templates is none")
    with _beside(path, mark).open("rb") as file:
        content = file.read(count * slam.views.templates[0].size)
    if zlib.crc32(content) != named["sum"]:
        raise ValueError("its templates are not those it was saved with")
    slam.views.restore(np.frombuffer(content, np.uint8).reshape(count, *shape), mark)


def _fill(slam: RatSlam, arrays: dict[str, Any], rest: dict[str, Any]) -> None:
    graph, views, log = slam.map, slam.views, slam.change_log
    graph.count, graph.linked = len(arrays["node_ids"]), len(arrays["link_sources"])
    arrays.setdefault("link_taken", np.ones(graph.linked, np.bool_))  # older maps have none
    for owner, prefix, names, count in (
        (views, "view", OF_VIEWS, views.count),
        (graph, "node", [name for name, _, _ in NODES], graph.count),
        (graph, "link", [name for name, _, _ in LINKS], graph.linked),
    ):
        for name in names:
            _put(owner, name, arrays[f"{prefix}_{name}"], count)
    for name, count in zip(OF_LOG, (graph.count, graph.count, graph.linked), strict=True):
        setattr(log, name, _like(getattr(log, name), arrays[f"told_{name}"], count, name))
    slam.cells.cells = _like(slam.cells.cells, arrays["cells"], len(slam.cells.cells), "cells")
    heirs = arrays.get("heirs", np.zeros((0, 2), np.int64))  # older maps have none
    slam.heirs = dict(_like(np.zeros((0, 2), np.int64), heirs, len(heirs), "heirs").tolist())
    log.whole_since = int(rest["whole_since"])
    slam.sequence, slam.view, slam.pruned_at = int(rest["sequence"]), int(rest["view"]), int(rest["pruned_at"])
    slam.keep, slam.last = frozenset(map(int, rest["keep"])), bytes.fromhex(rest["last"])
    slam.odometry = Calibration(
        **{name: type(now)(rest["odometry"][name]) for name, now in asdict(Calibration()).items()}
    )
    for number, place in rest["docks"].items():
        slam.docks.places[int(number)] = DockPlace(int(place["times"]), float(place["z"]), float(place["theta"]))
    slam.cells.best, graph.since = _three(rest["best"]), _three(rest["since"])
    graph.doubts = [Doubt(_three(m), int(since), float(gone), int(n)) for m, since, gone, n in rest["doubts"]]
    for name in OF_GRAPH:
        if name != "since":
            setattr(graph, name, type(getattr(graph, name))(rest[name]))
    ends = np.concatenate([graph.sources[: graph.linked], graph.targets[: graph.linked], [graph.current]])
    seen = np.concatenate([graph.views[: graph.count], [slam.view]])
    ids = np.concatenate([graph.ids[: graph.count], [graph.next_id]])
    fits = (np.diff(ids) > 0).all() and (graph.count == 0) == (graph.current < 0)
    if not (fits and _within(ends, graph.count) and _within(seen, views.count)):
        raise ValueError("its parts do not fit together")
    cells = slam.cells.cells
    if (
        cells.min() < 0
        or not 0.99 < cells.sum() < 2.0
        or not np.isfinite(
            [graph.seconds, graph.still, *(d.distance for d in graph.doubts), *astuple(slam.odometry)]
        ).all()
    ):
        raise ValueError("its numbers are no map's")
    pairs = zip(graph.sources[: graph.linked].tolist(), graph.targets[: graph.linked].tolist(), strict=True)
    graph.pairs = {(min(a, b), max(a, b)): n for n, (a, b) in enumerate(pairs)}


def _within(numbers: np.ndarray, count: int) -> bool:
    """Tell whether all are indices below count; the last may be -1 for none."""
    return bool((numbers[:-1] >= 0).all() and (numbers < count).all() and numbers[-1] >= -1)


def _put(owner: Any, name: str, found: np.ndarray, count: int) -> None:
    """Replace an array by one that begins with the stored values and has room for more."""
    room = getattr(owner, name)
    checked = _like(room, found, count, name)
    grown = np.zeros((max(64, count), *room.shape[1:]), room.dtype)
    grown[:count] = checked
    setattr(owner, name, grown)


def _like(model: np.ndarray, found: np.ndarray, count: int, name: str) -> np.ndarray:
    """Return `found`. Raises ValueError unless it is finite, of the model's kind and shape, and `count` long."""
    if found.dtype != model.dtype or found.shape != (count, *model.shape[1:]) or not np.isfinite(found).all():
        raise ValueError(f"{name} has another shape or kind")
    return found


def _three(values: Any) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    if not np.isfinite([x, y, z]).all():
        raise ValueError("a pose is not finite")
    return x, y, z
