"""Compiles every loop before the robot moves: at the first start on a machine this takes many seconds."""

import numpy as np

from robots.kit.slam.routes import plan
from robots.kit.slam.settings import Settings
from robots.kit.slam.slam import RatSlam


def compile_loops(settings: Settings | None = None) -> None:
    """Drive a map of a few random pictures that is thrown away. Quick where the compiled code is kept."""
    slam, dice = RatSlam(settings), np.random.default_rng(0)
    kept = slam.settings.views
    for n in range(4):
        blocks = dice.integers(0, 256, (kept.bottom, kept.width)).astype(np.uint8)
        slam.step(n, blocks, 0.2, 0.1, 0.5)
    plan(slam.map, 0)
