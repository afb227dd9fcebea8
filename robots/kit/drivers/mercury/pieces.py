"""The pieces of a simulated bed, for the register of finds."""

from robots.kit.contract.excavation import HiddenPiece
from robots.kit.drivers.mercury.beds import places


def pieces(secret: str, number: int) -> tuple[HiddenPiece, ...]:
    """Return the pieces of a bed."""
    return tuple(HiddenPiece(name, x / 1000, y / 1000) for name, (x, y) in places(secret, number).items())
