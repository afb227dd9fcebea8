"""Excavation: a robot uncovers hidden pieces. People report what they find, staff hide the pieces again."""

from dataclasses import dataclass

from robots.kit.contract.floor import Box


@dataclass(frozen=True)
class HiddenPiece:
    """A piece, by its name, and where it is hidden (m, in the frame of the robot's pose)."""

    name: str
    x: float
    y: float


@dataclass(frozen=True)
class Excavation:
    """The robot digs for hidden pieces in the rectangle `area` (x, y of two corners, m).

    A completed command `kind` digs once, at the `x` and `y` (m) that its driver says it `sent`; `once` and `often` are
    the words for one of them and for several. The map of what was dug has cells of `cell_m`. `pieces(secret, number)`
    names the function that returns the `HiddenPiece`s of a simulated bed, from the secret that its simulator is given
    and the number of the bed: nobody works out places from the number alone. `renewed_by` is the command of
    the lane `config`, asked by nobody but the portal, that makes a simulated bed anew, with its argument `number`, that
    of the round; without it staff hide the pieces by hand, as with every real robot. `puzzle` is what people are asked
    to find out in the first round of a simulated bed.
    """

    kind: str
    area: Box
    pieces: str = ""
    renewed_by: str = ""
    once: str = "time"
    often: str = "times"
    cell_m: float = 0.04
    puzzle: str = ""
