"""The times of a movie's packets: polyharmonic broadcasting of segments of any length and size.

A segment that is shown `start` after the beginning is sent again and again, evenly, in a period of `wait + start`. In
any period each of its packets is sent once, so a viewer who joins at any moment and waits `wait` has all of it when it
is shown. With segments of one slot each and a wait of m slots these are the channels of `schedule.polyharmonic`.
`guard` is taken off each period, for delays of sending, the network and one repair. Times are exact, whole nanoseconds.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from portal.broadcast.packets import PAYLOAD

SECOND = 10**9
GOLDEN = 618_034  # millionths: neighbours begin apart, so that channels do not send all at once


@dataclass(frozen=True)
class Channel:
    """One segment of `size` bytes, all of it once in each `period_ns`, as so many packets that are evenly apart."""

    segment: int
    size: int
    period_ns: int
    packets: int
    phase_ns: int

    def at(self, n: int) -> int:
        """Return when its packet n is sent (ns since the broadcast began)."""
        return self.phase_ns + n * self.period_ns // self.packets

    def piece(self, n: int) -> tuple[int, int]:
        """Return which bytes packet n has: where they begin and end in the segment."""
        k = n % self.packets
        return self.size * k // self.packets, self.size * (k + 1) // self.packets

    def first(self, since_ns: int) -> int:
        """Return the first packet that is not sent before this moment."""
        return -(-(since_ns - self.phase_ns) * self.packets // self.period_ns)

    def complete(self, joined_ns: int) -> int:
        """Return when a viewer who joins at this moment has all of it."""
        return self.at(self.first(joined_ns) + self.packets - 1)

    @property
    def bandwidth(self) -> Fraction:
        """Return how many bytes of the segment are sent a second."""
        return Fraction(self.size * SECOND, self.period_ns)


def channels(
    sizes: Sequence[int], starts_ns: Sequence[int], wait_ns: int, guard_ns: int = 0, payload: int = PAYLOAD
) -> tuple[Channel, ...]:
    """Return the channel of each segment, of so many bytes (above 0) and shown from there on.

    Raises ValueError where no time is left to send one.
    """
    if guard_ns >= wait_ns:
        raise ValueError("The wait of a joiner must be longer than the guard.")
    made = []
    for segment, (size, start) in enumerate(zip(sizes, starts_ns, strict=True)):
        period, packets = wait_ns + start - guard_ns, -(-size // payload)
        phase = segment * GOLDEN % 10**6 * period // (packets * 10**6)
        made.append(Channel(segment, size, period, packets, phase))
    return tuple(made)


def bytes_a_second(table: Sequence[Channel], head: int = 0) -> Fraction:
    """Return the bytes a second of all channels, with so many bytes of headers a packet."""
    return sum((one.bandwidth + Fraction(head * one.packets * SECOND, one.period_ns) for one in table), Fraction(0))
