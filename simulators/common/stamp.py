"""A time stamp in a picture, for measuring how old a picture is when somebody sees it.

Two rows of cells of 8 x 8 pixels begin at the upper left corner, 12 cells each, the highest bit first: the 16 lower
bits of the time in ms since 1970, then 8 bits of check (the two bytes of the time and 0xA5, exclusive or). White is
one. The cells are as large as the blocks of JPEG, so that a low quality does not spoil them.
"""

import numpy as np
from numpy.typing import NDArray

CELL, COLUMNS, ROWS = 8, 12, 2
WRAP_MS = 1 << 16
Picture = NDArray[np.uint8]


def painted(picture: Picture, ms: int) -> Picture:
    """Return a copy with the time in it. Raises ValueError if the picture is smaller than 96 x 16 pixels."""
    if picture.shape[0] < CELL * ROWS or picture.shape[1] < CELL * COLUMNS:
        raise ValueError(f"a stamp needs {CELL * COLUMNS} x {CELL * ROWS} pixels")
    time = ms % WRAP_MS
    number = time << 8 | check(time)
    bits = np.array([number >> place & 1 for place in reversed(range(COLUMNS * ROWS))], np.uint8)
    cells = np.kron(bits.reshape(ROWS, COLUMNS) * 255, np.ones((CELL, CELL), np.uint8))
    stamped = picture.copy()
    stamped[: CELL * ROWS, : CELL * COLUMNS] = cells if picture.ndim == 2 else cells[:, :, None]
    return stamped


def read(picture: Picture) -> int | None:
    """Return the time in ms modulo 65536; None if there is no stamp, or it cannot be read."""
    if picture.shape[0] < CELL * ROWS or picture.shape[1] < CELL * COLUMNS:
        return None
    grey = picture if picture.ndim == 2 else picture.mean(axis=2)
    middles = grey[CELL // 2 : CELL * ROWS : CELL, CELL // 2 : CELL * COLUMNS : CELL]
    number = 0
    for bit in (middles > 127).ravel():
        number = number << 1 | int(bit)
    time = number >> 8
    return time if number & 0xFF == check(time) else None


def check(time: int) -> int:
    """Return the check of a time of 16 bits; neither a black nor a white picture has it."""
    return (time >> 8 ^ time & 0xFF ^ 0xA5) & 0xFF
