"""Harmonic broadcasting: which part of a movie each channel sends when, and whether each joiner has it in time.

A movie of n segments of equal length is sent on several channels again and again, for any number of joiners. Time is
counted in slots, the length of a segment; a part of the movie is a place in it, in slots from its beginning; a
bandwidth is in units of the rate b at which the movie is shown. All are exact (`Fraction`). A segment that is sent
evenly in k slots needs b / k, and a joiner who listens for k slots, from whichever moment, has all of it.

Three schemes: harmonic (Juhn and Tseng 1997), which some joiners get late; cautious harmonic and polyharmonic (Paris,
Carter and Long 1998), which nobody gets late. No I/O and no clock.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

Exact = Fraction | int


@dataclass(frozen=True)
class Channel:
    """Sends its segments (numbers from 1) in turn, each evenly in so many slots; begins with the first at slot 0."""

    segments: tuple[int, ...]
    slots: int

    @property
    def bandwidth(self) -> Fraction:
        """Return its bandwidth, in units of b."""
        return Fraction(1, self.slots)

    @property
    def cycle(self) -> int:
        """Return after how many slots it begins again."""
        return self.slots * len(self.segments)

    def place(self, at: Exact) -> Fraction:
        """Return which place of the movie is sent at this moment (slots; not below 0)."""
        turn, into = divmod(Fraction(at), self.slots)
        return self.segments[int(turn) % len(self.segments)] - 1 + into / self.slots

    def next_time(self, place: Exact, since: Exact) -> Fraction:
        """Return when a place of one of its segments is next sent, not before `since`."""
        segment = math.floor(place)
        first = self.slots * (self.segments.index(segment + 1) + Fraction(place) - segment)
        return first + self.cycle * max(0, math.ceil((since - first) / self.cycle))


@dataclass(frozen=True)
class Scheme:
    """The channels of a movie, and when a joiner begins to show it.

    `wait`: so many slots after joining; none: at the next beginning of a slot, as the first segment begins then.
    """

    name: Literal["harmonic", "cautious", "polyharmonic"]
    channels: tuple[Channel, ...]
    wait: int | None = None

    @property
    def segments(self) -> int:
        """Return how many segments the movie has."""
        return sum(len(channel.segments) for channel in self.channels)

    @property
    def bandwidth(self) -> Fraction:
        """Return the bandwidth of all channels, in units of b."""
        return sum((channel.bandwidth for channel in self.channels), Fraction(0))

    def channel_of(self, segment: int) -> Channel:
        """Return the channel that sends this segment."""
        return next(channel for channel in self.channels if segment in channel.segments)

    def begin(self, joined: Exact) -> Fraction:
        """Return when a viewer who joins at this moment begins to show the movie."""
        return Fraction(math.ceil(joined) if self.wait is None else joined + self.wait)

    def received(self, place: Exact, joined: Exact) -> Fraction:
        """Return when a viewer who joins at this moment has this place of the movie."""
        return self.channel_of(math.floor(place) + 1).next_time(place, joined)


def _each(first: int, segments: range) -> tuple[Channel, ...]:
    """Return a channel for each segment: the first in `first` slots, each other in one more than the one before."""
    return tuple(Channel((segment,), first + number) for number, segment in enumerate(segments))


def harmonic(segments: int) -> Scheme:
    """Return Juhn and Tseng's scheme: segment i on channel i with b / i, H(n) in all. Some joiners get parts late.

    L.-S. Juhn and L.-M. Tseng, "Harmonic broadcasting for video-on-demand service", IEEE Transactions on Broadcasting
    43(3), 1997.
    """
    return Scheme("harmonic", _each(1, range(1, segments + 1)))


def cautious(segments: int) -> Scheme:
    """Return the cautious scheme: b / 2 more than harmonic with one segment fewer. At least three segments.

    The second channel sends segments 2 and 3 in turn at the full rate; channel i sends segment i + 1 with b / i.
    J.-F. Paris, S. W. Carter and D. D. E. Long, "Efficient broadcasting protocols for video on demand", MASCOTS 1998.
    """
    if segments < 3:
        raise ValueError("The cautious scheme needs three segments.")
    return Scheme("cautious", (Channel((1,), 1), Channel((2, 3), 1), *_each(3, range(4, segments + 1))))


def polyharmonic(segments: int, wait: int = 4) -> Scheme:
    """Return the polyharmonic scheme: everybody waits m (`wait`) slots; segment i is sent with b / (m + i - 1).

    H(n + m - 1) - H(m - 1) in all. J.-F. Paris, S. W. Carter and D. D. E. Long, "A low bandwidth broadcasting protocol
    for video on demand", ICCCN 1998.
    """
    return Scheme("polyharmonic", _each(wait, range(1, segments + 1)), wait)


def lateness(scheme: Scheme, joined: Exact) -> Fraction:
    """Return how late the latest place of the movie comes to a viewer who joins now (slots; least upper bound).

    If it is not above 0, everything is there when it is shown. Within a segment a place is sent `slots` times as slowly
    as it is shown, but for one jump, at the place that is sent at the moment of joining; so the latest places are the
    ends of both pieces.
    """
    begin, latest = scheme.begin(joined), []
    for channel in scheme.channels:
        now = channel.place(joined)
        for segment in channel.segments:
            for end in {Fraction(segment), now if segment - 1 < now < segment else Fraction(segment)}:
                took = channel.slots * (end - segment + 1)  # from the segment's beginning to this end
                sent = channel.next_time(segment - 1, joined - took) + took
                if sent <= joined:  # the part just before the end was missed, and comes in the next cycle
                    sent += channel.cycle
                latest.append(sent - (begin + end))
    return max(latest)


def on_time(scheme: Scheme, joined: Exact) -> bool:
    """Return whether a viewer who joins at this moment has each place of the movie when it is shown."""
    return lateness(scheme, joined) <= 0


def least(length: float, wait: float) -> float:
    """Return the least bandwidth with which any scheme can serve every joiner, in units of b: ln(1 + length / wait)."""
    return math.log1p(length / wait)
