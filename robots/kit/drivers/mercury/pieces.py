"""Where the pieces of a simulated bed lie, by the bed's number. Bed 1 is the one of every new simulator.

Whoever knows the number knows the places, so staff alone are told numbers.
"""

from random import Random

from robots.kit.contract.excavation import HiddenPiece

FIRST = {
    "watch": (-150, 470), "whist card": (40, 500), "elephant": (165, 455), "engine": (-60, 345),
    "banknote": (-185, 350), "ticket": (110, 350), "calendar leaf": (5, 420), "bag": (-70, 520),
    "gas burner": (205, 525),
}  # fmt: skip
COLUMNS, ROWS = (-155, 0, 155), (335, 420, 505)  # mm; the middles of the fields, one for each piece
ASIDE_X, ASIDE_Y = 40, 10  # mm; the most by which a piece lies beside its middle


def places(number: int) -> dict[str, tuple[float, float]]:
    """Return the middle of each piece by its name, x and y in mm."""
    if number == 1:
        return {name: (float(x), float(y)) for name, (x, y) in FIRST.items()}
    chance = Random(number).random
    fields = sorted(((x, y) for x in COLUMNS for y in ROWS), key=lambda _: chance())
    return {
        name: (x + (2 * chance() - 1) * ASIDE_X, y + (2 * chance() - 1) * ASIDE_Y)
        for name, (x, y) in zip(FIRST, fields, strict=True)
    }


def pieces(number: int) -> tuple[HiddenPiece, ...]:
    """Return the pieces of a bed."""
    return tuple(HiddenPiece(name, x / 1000, y / 1000) for name, (x, y) in places(number).items())
