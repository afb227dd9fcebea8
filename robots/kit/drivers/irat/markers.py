"""The two markers of the dock: an outer one for the approach, a small one in its centre for the last centimetres.

ArUco markers of 3 x 3 bits within a black border of one cell: fewer and larger cells than any predefined dictionary
has, so that a marker of seven pixels can be read. 1 is white. The four corners and the four sides of the code each have
a pattern that no quarter turn repeats, so a turned marker differs in at least four bits from any that is not turned,
and from the other marker in at least four. The small marker is in the outer one's centre cell, which therefore reads as
black or as white: the outer marker has both codes.
"""

OUTER_M = 0.075  # side of the outer marker with its border (the paper's)
CELLS = 5  # three bits and the border on both sides
CELL_M = OUTER_M / CELLS
SMALL_M = 0.012  # side of the small marker; a white margin of 1.5 mm is left in the centre cell
HEIGHT_M = 0.06  # of both centres above the floor, the camera's own

OUTER = ((1, 1, 1), (0, 0, 0), (0, 0, 1))
OUTER_IDS = (0, 1)  # of `BITS`: the outer marker, with a black and with a white centre
SMALL_ID = 2
SMALL = ((1, 0, 1), (0, 0, 1), (0, 1, 0))


def _with_centre(bits: tuple[tuple[int, ...], ...], centre: int) -> tuple[tuple[int, ...], ...]:
    return bits[0], (bits[1][0], centre, bits[1][2]), bits[2]


BITS = (_with_centre(OUTER, 0), _with_centre(OUTER, 1), SMALL)


def turned(bits: tuple[tuple[int, ...], ...]) -> tuple[tuple[int, ...], ...]:
    """Return a code turned by a quarter, clockwise."""
    return tuple(zip(*bits[::-1], strict=True))
