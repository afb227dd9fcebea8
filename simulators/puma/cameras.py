"""The two cameras of the cell, in a separate process: ``python -m simulators.puma.cameras --dir DIR``."""

from functools import partial
from pathlib import Path

from simulators.common.arm import cameras
from simulators.puma import scene
from simulators.puma.cell import DRIVER
from simulators.puma.errors import errors_of, kept_seed
from simulators.puma.render import RasterRenderer


class Cameras(cameras.Cameras):
    """The cell's views, with the errors of the seed that the simulator keeps in its folder."""

    def __init__(self, folder: Path, seed: int | None = None, width: int | None = None) -> None:
        spec = scene.spec(errors_of(kept_seed(folder)))
        super().__init__(DRIVER, spec, folder, seed, width, RasterRenderer)


run = partial(cameras.run, Cameras)


if __name__ == "__main__":
    cameras.main(Cameras, __doc__)
