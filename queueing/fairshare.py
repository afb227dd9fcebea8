"""Start-time fair queueing (Goyal, Vin, Cheng 1996), as pure functions.

A ticket's start tag is max(V, F of its user) and does not change while it waits. The queue is served in the order of
tags. F grows by the charged seconds divided by the weight. V is the tag in service. When the queue is empty, V becomes
the greatest finish tag served; otherwise absence would earn credit.
"""

from dataclasses import dataclass

ALONE_CHARGE = 0.5  # cost of a second while nobody waits
ANSWER_S = 30.0  # the latest answer to an offer
Range = tuple[float, float]


@dataclass(frozen=True)
class Clock:
    """A queue's virtual time and the greatest finish tag that it has served."""

    virtual: float = 0.0
    greatest_finish: float = 0.0

    def serve(self, start_tag: float) -> "Clock":
        """Return the clock after a ticket goes into service."""
        return Clock(max(self.virtual, start_tag), self.greatest_finish)

    def finish(self, finish_tag: float) -> "Clock":
        """Return the clock after a turn has ended and was charged."""
        return Clock(self.virtual, max(self.greatest_finish, finish_tag))

    def empty(self) -> "Clock":
        """Return the clock if nobody waits and nobody is served."""
        return Clock(max(self.virtual, self.greatest_finish), self.greatest_finish)


def start_tag(clock: Clock, user_finish: float) -> float:
    """Return the start tag of a ticket that joins now."""
    return max(clock.virtual, user_finish)


def finish_tag(tag: float, charged_s: float, weight: float) -> float:
    """Return the user's finish tag after `charged_s` seconds. Raises ValueError for a weight <= 0."""
    if weight <= 0:
        raise ValueError("a weight must be positive")
    return tag + max(0.0, charged_s) / weight


def chargeable_s(used_s: float, alone_s: float) -> float:
    """Return the seconds to charge: time while nobody waits costs less."""
    alone = min(max(0.0, alone_s), max(0.0, used_s))
    return max(0.0, used_s) - alone * (1 - ALONE_CHARGE)


def turns_range(people: int, lengths: int, turn_s: float, handover_s: Range) -> Range:
    """Return the least and greatest time of a turn of each of these people and its handover (s).

    A turn takes a quarter of its time, or all of it after a late answer. `lengths`: how many times as long as usual
    the turns of these people are, added up. `handover_s`: the least and greatest time of one.
    """
    least, most = handover_s
    return lengths * turn_s * 0.25 + people * least, lengths * (turn_s + ANSWER_S) + people * most


def estimate(ahead: int, lengths: int, running_left_s: float, turn_s: float, handover_s: Range) -> tuple[int, int]:
    """Return the least and greatest wait (s) of a person with `ahead` people before them, after the running turn.

    `lengths` and `handover_s`: as of `turns_range`, of the people before.
    """
    least, most = turns_range(ahead, lengths, turn_s, handover_s)
    low = min(running_left_s, turn_s * 0.1) + least
    high = running_left_s + handover_s[1] + most
    return round(low), round(max(low, high))
