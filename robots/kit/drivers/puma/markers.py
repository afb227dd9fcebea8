"""The markers on the bricks: on its top and on both long sides each brick has one of its own.

Codes of 4 x 4 bits in a black border of one cell, the first fifteen of OpenCV's DICT_4X4_50; 1 is white. The printed
square has a white margin of half a cell around the border.
"""

from dataclasses import dataclass

Three = tuple[float, float, float]
CELLS = 6  # four bits and the border on both sides


@dataclass(frozen=True)
class Face:
    """A face of a brick: the side of its marker, in the brick's frame its middle (m), its right and its upper side."""

    side: float
    middle: Three
    right: Three
    up: Three

    @property
    def printed(self) -> float:
        """Return the side of the marker with its white margin (m)."""
        return self.side * (CELLS + 1) / CELLS


FACES = (
    Face(0.024, (0.0, 0.0, 0.0096), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    Face(0.0162, (0.0, -0.0159, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    Face(0.0162, (0.0, 0.0159, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
)
_ROWS = (
    "1011 0101 0011 0010", "0000 1111 1001 1010", "0011 0011 0010 1101", "1001 1001 0100 0110", "0101 0100 1001 1110",
    "0111 1001 1100 1101", "1001 1110 0010 1110", "1100 0100 1111 0010", "1111 1110 1101 1010", "1100 1111 0101 0110",
    "1111 1001 1001 0001", "0001 0001 1010 0111", "0000 1110 1011 0111", "0010 1010 0000 1111", "0010 0100 1011 0001",
)  # fmt: skip
BITS = {number: tuple(tuple(map(int, row)) for row in rows.split()) for number, rows in enumerate(_ROWS)}
SIDES = {number: FACES[number % len(FACES)].side for number in BITS}


def number_of(brick: int, face: int) -> int:
    """Return the number of the marker on a face of a brick; both are counted from 0, in the order of `FACES`."""
    return brick * len(FACES) + face


def brick_and_face(number: int) -> tuple[int, int]:
    """Return whose marker it is: the brick and the face, counted from 0."""
    return divmod(number, len(FACES))
