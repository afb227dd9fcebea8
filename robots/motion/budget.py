"""How much one request may have computed: planning is asked for by anybody, and its time must have a limit."""

from dataclasses import dataclass

MOST = 8000  # of one request
LINE_POINT = 4  # one inverse solution
SHARED = 80  # answers at a singular pose
LOOK, GLANCED_AT, LOOKED_AT = 15, 0.5, 1.5  # one look at the boxes; each posture in it, looked at roughly or exactly
MOTION = 25  # what else a motion wants


class TooMuch(ValueError):
    """The request wants more work than one may ask for."""


@dataclass
class Budget:
    """What is left of a request's work, in units of about 10 microseconds."""

    left: float

    def spend(self, units: float) -> None:
        """Take so much off. Raises TooMuch."""
        self.left -= units
        if self.left < 0:
            raise TooMuch(
                "this is more than may be planned at once: about 10 m of straight lines, or 150 motions that differ"
            )
