"""The museum arm's three cameras, in a separate process: ``python -m simulators.pa10.cameras --dir DIR``."""

from functools import partial
from pathlib import Path

from simulators.common.arm import cameras
from simulators.common.arm.cameras import NOISE as NOISE
from simulators.pa10 import scene


class Cameras(cameras.Cameras):
    """The arm's views; see there."""

    def __init__(self, folder: Path, seed: int | None = None, width: int | None = None) -> None:
        super().__init__("pa10", scene.spec(), folder, seed, width)


run = partial(cameras.run, Cameras)


if __name__ == "__main__":
    cameras.main(Cameras, __doc__)
