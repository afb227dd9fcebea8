"""One step of RatSLAM on a large map beside the published loops: the same templates, cells and links, the same answers."""

import time
from collections.abc import Callable

import numpy as np

from benchmarks import _published as published
from benchmarks.stage import median, tell
from robots.kit.slam import spreading
from robots.kit.slam.experiences import ExperienceMap
from robots.kit.slam.relaxing import relax
from robots.kit.slam.settings import CellSettings, MapSettings, ViewSettings
from robots.kit.slam.views import Views
from tests.unit.ratslam_world import INNER, OUTER, World

TEMPLATES, EXPERIENCES, QUERIES, ROUNDS = 3000, 5000, 24, 7
RING_M = 8.0
AUTHORS_MS = {"matching": 85.0, "cells": 4.4, "relaxation": 10.6}  # the authors' C++, measured once on 2 cores
FASTER, FAIR = 4.0, 1.5  # times as fast as the published loops, which take at most so many times the authors' time
PARTS = tuple(AUTHORS_MS)


def main() -> None:
    """Measure the three parts in turns, each round ours and theirs."""
    parts = {"matching": matching(), "cells": cells(), "relaxation": relaxation()}
    times: dict[str, tuple[list[float], list[float]]] = {name: ([], []) for name in parts}
    for _ in range(ROUNDS):  # a machine that is busy for a while is so for both
        for name, pair in parts.items():
            for kept, run in zip(times[name], pair, strict=True):
                kept.append(run())
    rows = {name: (median(ours), median(theirs)) for name, (ours, theirs) in times.items()}
    for name, (ours, theirs) in rows.items():
        print(
            f"{name}: ours {ours:.2f} ms, the published loops {theirs:.2f} ms ({theirs / ours:.1f} times as long; "
            f"the authors' C++ took {AUTHORS_MS[name]} ms)"
        )
    ratio = sum(theirs for _, theirs in rows.values()) / sum(ours for ours, _ in rows.values())
    beside = {name: {"ours_ms": round(a, 3), "published_ms": round(b, 3)} for name, (a, b) in rows.items()}
    fair = sum(theirs for _, theirs in rows.values()) / sum(AUTHORS_MS.values())
    print(f"the published loops take {fair:.2f} times as long as the authors' C++ took")
    goal, holds = f">= {FASTER:g}, and these at most {FAIR:g} times the authors' time", ratio >= FASTER and fair <= FAIR
    tell("ratslam_step", ratio, "times as fast as the published loops", goal, holds, beside)


Timed = Callable[[], float]


def timed(run: Callable[[], object], times: int = 1) -> float:
    """Return the milliseconds of the processor that one run takes."""
    begun = time.process_time()
    for _ in range(times):
        run()
    return (time.process_time() - begun) * 1000 / times


def places(count: int, dice: np.random.Generator) -> np.ndarray:
    """Return random places in the corridor, (count, 3): x, y, facing."""
    found: list[tuple[float, float, float]] = []
    while len(found) < count:
        x, y = dice.uniform(-1, 1, 2) * (np.array(OUTER) - 0.07)
        if max(abs(x) - INNER[0], abs(y) - INNER[1]) > 0.07:
            found.append((x, y, dice.uniform(-np.pi, np.pi)))
    return np.array(found)


def matching() -> tuple[Timed, Timed]:
    """Half of the views are of places seen before, a few millimetres off; half are new."""
    kept, world, dice = ViewSettings(), World(), np.random.default_rng(1)
    views = Views(kept)
    where = places(TEMPLATES, dice)
    for x, y, facing in where:
        views.add(views.view(world.picture(x, y, facing)), (0.0, 0.0, 0.0), 1.0)
    again = where[dice.choice(TEMPLATES, QUERIES // 2)] + dice.normal(0, 0.002, (QUERIES // 2, 3))
    asked = [views.view(world.picture(*at)) for at in np.concatenate([again, places(QUERIES // 2, dice)])]
    templates = views.templates[:TEMPLATES] / 255.0
    means = templates.mean(axis=(1, 2))
    greys = [(view / 255.0, float(view.mean() / 255.0)) for view in asked]

    def ours() -> list[tuple[int, float]]:
        return [views.match(view) for view in asked]

    def theirs() -> list[tuple[int, float]]:
        found = [published.match(view, mean, templates, means, kept.shift, kept.match) for view, mean in greys]
        return [(n, d) if d <= kept.match else (-1, d) for n, d in found]

    a, b = ours(), theirs()
    assert [n for n, _ in a] == [n for n, _ in b]
    assert all(abs(x - y) < 1e-9 for (n, x), (_, y) in zip(a, b, strict=True) if n >= 0)
    print(f"matching: {sum(n >= 0 for n, _ in a)} of {QUERIES} views recognised, the same by both")
    return lambda: timed(ours) / QUERIES, lambda: timed(theirs) / QUERIES


def cells() -> tuple[Timed, Timed]:
    """All cells active, as after long uncertainty, which is when the published loops skip none."""
    kept, dice = CellSettings(), np.random.default_rng(2)
    begin = dice.random((kept.around, kept.across, kept.across))
    begin /= begin.sum()
    lines = (
        spreading.line(kept.excite_width, kept.excite_sd),
        spreading.line(kept.inhibit_width, kept.inhibit_sd),
    )
    cubes = (
        published.cube(kept.excite_width, kept.excite_sd),
        published.cube(kept.inhibit_width, kept.inhibit_sd),
    )
    work = np.empty_like(begin)

    def ours() -> None:
        work[:] = begin
        spreading.compete(work, *lines, kept.inhibit_all)
        spreading.shift(work, 0.4, 0.3)

    def theirs() -> None:
        work[:] = begin
        published.step(work, *cubes, kept.inhibit_all, 0.4, 0.3)

    ours()
    expected = work.copy()
    theirs()
    np.testing.assert_allclose(work, expected, atol=1e-12)
    return lambda: timed(ours, 20), lambda: timed(theirs, 5)


def wandered(count: int) -> ExperienceMap:
    """Return a map of rounds through a ring of corridors of 8 m, each meeting experiences of earlier rounds now and then."""
    held, dice, at, spots = ExperienceMap(MapSettings()), np.random.default_rng(3), 0.0, [0.0]
    held.create(0, (0.0, 0.0, 0.0))
    while held.count < count:
        gone = dice.uniform(0.02, 0.04)
        at = (at + gone) % RING_M
        held.move(gone, gone / RING_M * 2 * np.pi + dice.normal(0, 0.02), gone / 0.1 + dice.exponential(0.1))
        apart = np.abs(np.array(spots) - at)
        near = np.flatnonzero(np.minimum(apart, RING_M - apart) < 0.03)
        near = near[near < held.count - 50]
        if len(near) and dice.random() < 0.15:
            held.meet(int(dice.choice(near)), (0.0, 0.0, 0.0))
        else:
            held.create(0, (0.0, 0.0, 0.0))
            spots.append(at)
    return held


def relaxation() -> tuple[Timed, Timed]:
    """Twenty loops over all links."""
    held = wandered(EXPERIENCES)
    n, m, kept = held.count, held.linked, held.settings
    order = np.argsort(held.sources[:m], kind="stable")
    begins = np.searchsorted(held.sources[:m][order], np.arange(n + 1))
    begin = held.poses[:n].copy()
    poses, split = begin.copy(), begin.T.copy()

    def ours() -> None:
        poses[:] = begin
        relax(poses, held.sources[:m], held.targets[:m], held.measured[:m], order, kept.loops, kept.correction)

    def theirs() -> None:
        split[:] = begin.T
        published.relax(*split, begins, order, held.targets[:m], held.measured[:m], kept.loops, kept.correction)

    ours()
    theirs()
    np.testing.assert_allclose(poses.T, split, atol=1e-9)
    return lambda: timed(ours), lambda: timed(theirs)
