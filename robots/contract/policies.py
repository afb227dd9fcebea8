"""What a motion may go on with when others are held: pure data, and the rule that judges it.

A robot is held when its grant ends and when the connection is lost. A kind of command may say otherwise, inside
a `Bound`; whatever it says, nothing moves past the end of the open grant.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Literal

Why = Literal["", "link", "grant"]


@dataclass(frozen=True)
class Range:
    """The range in which a joint, a coordinate of the pose or a channel has to stay, in its own unit."""

    name: str
    low: float
    high: float


@dataclass(frozen=True)
class Bound:
    """For how long (s), where, and how fast at most a robot may go on.

    `area` are ranges of what its state tells; `speed` is the greatest velocity of any joint (rad/s, m/s). What the
    state does not tell counts as outside.
    """

    seconds: float
    area: tuple[Range, ...] = ()
    speed: float | None = None


@dataclass(frozen=True)
class Policies:
    """What a kind of command may do instead of being held at once; None is to be held.

    `on_link_lost`: it goes on inside the bound for at most its seconds after the connection was lost.
    `on_grant_end`: in the last seconds before its grant ends it goes on inside the bound only, so that the hold at
    the end finds it slow, or where it may stay.
    """

    on_link_lost: Bound | None = None
    on_grant_end: Bound | None = None


HOLD = Policies()


@dataclass(frozen=True)
class Known:
    """What is known of the robot now: values by name and velocities of joints; None: nothing that is fresh."""

    values: Mapping[str, float]
    velocities: tuple[float, ...] = ()


def inside(bound: Bound, known: Known | None) -> bool:
    """Tell whether the robot is known to be inside the bound's area and speed."""
    if known is None:
        return not bound.area and bound.speed is None
    if not all(r.low <= known.values.get(r.name, inf) <= r.high for r in bound.area):
        return False
    if bound.speed is None:
        return True
    return bool(known.velocities) and all(abs(v) <= bound.speed for v in known.velocities)


def why_held(policies: Policies, now: float, lost_at: float | None, until: float, known: Known | None) -> Why:
    """Return why a motion has to be held now: for its grant, for the connection; empty while it may go on.

    Times are monotonic (s): `lost_at` since when the connection is lost (None: it is not), `until` when the
    grant ends.
    """
    if not now < until:
        return "grant"
    if lost_at is not None:
        alone = policies.on_link_lost
        if alone is None or not now < lost_at + alone.seconds or not inside(alone, known):
            return "link"
    last = policies.on_grant_end
    if last is not None and now >= until - last.seconds and not inside(last, known):
        return "grant"
    return ""
