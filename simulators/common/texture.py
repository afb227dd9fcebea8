"""Textures for the rasteriser: all of them in one array, each with its mipmaps."""

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]


class Atlas:
    """Textures by number.

    `texels` has all mipmaps of all textures one after another. A row of `table` has the index where a texture begins,
    its width, its height and its number of mipmaps; each mipmap has a quarter of the texels of the one before.
    """

    def __init__(self) -> None:
        self.texels = np.zeros(3, np.uint8)
        self.table = np.zeros((0, 4), np.int64)

    def add(self, picture: Picture) -> int:
        """Add a picture (height, width, 3) whose sides are powers of two; return its number.

        Raises:
            ValueError: a side that is no power of two.

        """
        height, width = picture.shape[:2]
        if not height or not width or height & (height - 1) or width & (width - 1):
            raise ValueError(f"a texture's sides are powers of two, not {width} x {height}")
        levels = [picture]
        while levels[-1].shape[0] > 1 or levels[-1].shape[1] > 1:
            levels.append(_halved(levels[-1]))
        row = [len(self.texels), width, height, len(levels)]
        self.table = np.concatenate([self.table, np.array([row], np.int64)])
        self.texels = np.concatenate([self.texels, *(level.reshape(-1) for level in levels)])
        return len(self.table) - 1


def _halved(picture: Picture) -> Picture:
    """Return the picture with half the width and height, at least 1."""
    rows, columns = min(2, picture.shape[0]), min(2, picture.shape[1])
    parts = [picture[i::rows, j::columns].astype(np.float32) for i in range(rows) for j in range(columns)]
    return np.asarray(sum(parts) / len(parts) + 0.5, np.uint8)
