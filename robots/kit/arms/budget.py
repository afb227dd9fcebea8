"""The limit of work for planning one request, because everybody may request a plan."""

from dataclasses import dataclass

MOST = 8000  # for one request
LINE_POINT = 4  # one inverse solution
SHARED = 80  # answers at a singular pose
LOOK, GLANCED_AT, LOOKED_AT = 15, 0.5, 1.5  # one check of the boxes; each posture in it, checked coarsely or exactly
MOTION = 25  # other work of a motion


class TooMuch(ValueError):
    """The request needs more work than allowed."""


@dataclass
class Budget:
    """The rest of the work for a request, in units of about 10 microseconds."""

    remaining: float

    def spend(self, units: float) -> None:
        """Use so much of it. Raises TooMuch."""
        self.remaining -= units
        if self.remaining < 0:
            raise TooMuch(
                "this is more than may be planned at once: about 10 m of straight lines, or 150 motions that differ"
            )
