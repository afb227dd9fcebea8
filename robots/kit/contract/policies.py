"""Bounds inside which a motion may go on when others are held: pure data, applied by the owner's gate.

A robot is held when its grant ends and when the connection is lost. A kind of command may go on inside a `Bound`; but
nothing moves past the end of the open grant.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Range:
    """The range in which a joint, a coordinate of the pose or a channel has to stay, in its own unit."""

    name: str
    low: float
    high: float


@dataclass(frozen=True)
class Bound:
    """The bound of a motion that goes on: for how long (s), where, and how fast at most.

    `area` are ranges of what its state tells; `speed` is the greatest velocity of any joint (rad/s, m/s) and of the
    body (m/s), `turn` the greatest rate at which the body turns (rad/s). A value that the state does not tell counts as
    outside. With `setting`, the value that staff have set under that name replaces `seconds`; 0 there: it is held.
    """

    seconds: float
    area: tuple[Range, ...] = ()
    speed: float | None = None
    turn: float | None = None
    setting: str = ""


@dataclass(frozen=True)
class Policies:
    """The bounds of a kind of command in two events; None: it is held at once.

    `on_link_lost`: it goes on inside the bound for at most its seconds after the connection was lost.
    `on_grant_end`: in the last seconds before its grant ends it goes on inside the bound only, so that the hold at
    the end finds it slow, or where it may stay.
    """

    on_link_lost: Bound | None = None
    on_grant_end: Bound | None = None

    def by(self, settings: Mapping[str, Any]) -> "Policies":
        """Return the policies of a robot with these settings."""
        return Policies(_by(self.on_link_lost, settings), _by(self.on_grant_end, settings))


def _by(bound: Bound | None, settings: Mapping[str, Any]) -> Bound | None:
    if bound is None or bound.setting not in settings:
        return bound
    seconds = float(settings[bound.setting])
    return replace(bound, seconds=seconds) if seconds > 0 else None


HOLD = Policies()
