"""Compiled loops: all of them before the robot moves, and also where no folder can keep them."""

import numba
import numpy as np
import pytest
from numba.core.registry import CPUDispatcher

from robots.kit import compiled
from robots.kit.slam import angles, relaxing, shortest, spreading, views
from robots.kit.slam.slam import RatSlam, compile_loops
from tests.unit.ratslam_world import World


def loops():
    modules = (angles, relaxing, shortest, spreading, views)
    return [value for module in modules for value in vars(module).values() if isinstance(value, CPUDispatcher)]


def test_after_getting_ready_nothing_is_left_to_compile():
    compile_loops()
    before = {loop.py_func.__name__: len(loop.signatures) for loop in loops()}
    assert all(
        before[name] for name in ("row_sums", "best", "compete", "shift", "peak", "relax", "wrapped", "shortest")
    )
    slam, world = RatSlam(), World()
    for n, x in enumerate((-0.6, -0.3, 0.0, 0.3, -0.6)):
        slam.step(n, world.picture(x, -0.775, 0.0), 0.3, 0.0, 1.0)
    assert {loop.py_func.__name__: len(loop.signatures) for loop in loops()} == before


def test_where_no_folder_can_keep_the_code_it_is_compiled_all_the_same(monkeypatch):
    real = numba.njit

    def homeless(*args, **kwargs):
        if kwargs.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return real(*args, **kwargs)

    monkeypatch.setattr(compiled.numba, "njit", homeless)
    assert compiled.compiled(lambda a: a + 1)(2) == 3


@pytest.mark.timed
def test_a_step_on_a_large_map_takes_a_few_milliseconds_of_the_processor(stopwatch):
    """Ten pictures a second must leave the machine to others: 2 000 templates and experiences, 30 ms a step at most."""
    slam, dice = RatSlam(), np.random.default_rng(1)
    compile_loops()
    for n in range(2000):
        slam.map.move(0.03, 0.02, 0.3)
        slam.views.add(dice.integers(0, 256, (20, 60)).astype(np.uint8), (7.0, 7.0, float(n % 36)), 1.0)
        slam.map.create(n, (7.0, 7.0, float(n % 36)))
    begun = stopwatch.process_time()
    for n in range(20):
        blocks = dice.integers(0, 256, (20, 60)).astype(np.uint8).repeat(12, 0).repeat(7, 1)[:, :416]
        assert slam.step(n, blocks, 0.1, 0.1, 0.1).is_new
    assert stopwatch.process_time() - begun < 20 * 0.03
