"""The capability of a robot that brings the things around it back to where they belong. Pure data."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from robots.kit.contract.capabilities import Setting

LONGEST_S = 300.0
TIDY_S = "tidy_s"


@dataclass(frozen=True)
class Tidy:
    """A command that brings things back to their first places; staff may ask for it, and handover may give it.

    Its argument `seconds` is how long it may take at most. What it cannot bring back it leaves, and raises GaveUp with
    a sentence for each such thing; then the robot is at rest, and can be used. `setting` is the time that staff allow
    for it between two turns (s); 0: it is not given there.
    """

    kind: str

    @property
    def setting(self) -> Setting:
        """Return what staff may set, which the spec declares too."""
        return Setting(
            TIDY_S, "Tidy up between two turns, for at most", unit="s", high=LONGEST_S, low=0.0, default=0.0,
            help="What a turn has left somewhere else is brought back to its place before the next turn begins, as far"
            " as this time allows; a thing takes about 20 s. 0: not between turns, only when staff ask for it.",
        )  # fmt: skip

    def seconds(self, values: Mapping[str, Any]) -> float:
        """Return how long staff allow for it between two turns (s), by the values that they have set."""
        return float(values.get(self.setting.name, 0.0))
