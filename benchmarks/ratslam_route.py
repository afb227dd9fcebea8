"""A route over a map of 5 000 experiences beside the published way and networkx: the same durations."""

import time
from collections.abc import Callable

import networkx as nx
import numpy as np

from benchmarks import _published as published
from benchmarks.ratslam_step import EXPERIENCES, wandered
from benchmarks.stage import median, tell
from robots.kit.slam.routes import plan

GOALS, AUTHORS_MS = 12, 110.0


def main() -> None:
    """Plan the same routes with each, in turns."""
    held = wandered(EXPERIENCES)
    n, m = held.count, held.linked
    goals = np.random.default_rng(4).choice(n - 1, GOALS, replace=False).tolist()
    sources = np.concatenate([held.sources[:m], held.targets[:m]])
    order = np.argsort(sources, kind="stable")
    ends = np.concatenate([held.targets[:m], held.sources[:m]])[order]
    seconds = np.concatenate([held.durations[:m]] * 2)[order]
    begins = np.searchsorted(sources[order], np.arange(n + 1))
    graph = nx.Graph()
    graph.add_weighted_edges_from(
        zip(held.sources[:m].tolist(), held.targets[:m].tolist(), held.durations[:m].tolist(), strict=True)
    )
    ways: dict[str, Callable[[int], float]] = {
        "ours": lambda goal: plan(held, goal).seconds,  # type: ignore[union-attr]
        "published": lambda goal: float(published.dijkstra(begins, ends, seconds, held.current)[goal]),
        "networkx": lambda goal: nx.single_source_dijkstra(graph, held.current, goal)[0],
        "networkx, from both ends": lambda goal: nx.bidirectional_dijkstra(graph, held.current, goal)[0],
    }
    found = {name: [way(goal) for goal in goals] for name, way in ways.items()}
    for name, durations in found.items():
        np.testing.assert_allclose(durations, found["ours"], err_msg=name)
    times: dict[str, list[float]] = {name: [] for name in ways}
    for goal in goals:
        for name, way in ways.items():
            begun = time.process_time()
            way(goal)
            times[name].append((time.process_time() - begun) * 1000)
    rows = {name: median(taken) for name, taken in times.items()}
    for name, taken in rows.items():
        print(f"{name}: {taken:.2f} ms a route")
    print(f"the authors' C++ took {AUTHORS_MS:.0f} ms")
    ratio = min(taken for name, taken in rows.items() if name != "ours") / rows["ours"]
    beside = {name: round(taken, 3) for name, taken in rows.items()}
    tell("ratslam_route", ratio, "times as fast as the quickest other", ">= 5", ratio >= 5, beside)
