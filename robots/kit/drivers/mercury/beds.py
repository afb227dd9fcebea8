"""Where the pieces of a simulated bed lie: drawn from the installation's secret for the robot and the bed's number.

Numbers are no secret. Without a secret, as in tests, bed 1 is `FIRST`.
"""

from random import Random

MOST_BEDS = 2**24 - 1  # a number that four bytes of a float hold exactly
Places = dict[str, tuple[float, float]]
FIRST: Places = {
    "watch": (-150, 470), "whist card": (40, 500), "elephant": (165, 455), "engine": (-60, 345),
    "banknote": (-185, 350), "ticket": (110, 350), "calendar leaf": (5, 420), "bag": (-70, 520),
    "gas burner": (205, 525),
}  # fmt: skip
COLUMNS, ROWS = (-155, 0, 155), (335, 420, 505)  # mm; the middles of the fields, one for each piece
ASIDE_X, ASIDE_Y = 40, 10  # mm; the most by which a piece lies beside its middle


def places(secret: str, number: int) -> Places:
    """Return the middle of each piece by its name, x and y in mm."""
    if number == 1 and not secret:
        return {name: (float(x), float(y)) for name, (x, y) in FIRST.items()}
    chance = Random(f"{secret} {number}").random  # it hashes a text, so the secret does not follow from places
    fields = sorted(((x, y) for x in COLUMNS for y in ROWS), key=lambda _: chance())
    return {
        name: (x + (2 * chance() - 1) * ASIDE_X, y + (2 * chance() - 1) * ASIDE_Y)
        for name, (x, y) in zip(FIRST, fields, strict=True)
    }
