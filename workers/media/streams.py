"""The byte streams that the driver tells: numbered, kept since their last key packet, published beside the states."""

import threading
from dataclasses import dataclass, field

from robots import bus
from robots.kit.clock import Clock
from robots.kit.contract.streams import LONGEST, MOST_DELTAS, Stream, StreamPacket, pack

REFRESH_S = 5.0  # between two looks whether Redis still has the packets for newcomers


@dataclass
class _Outgoing:
    """One stream: the packets since its last key packet, and how many of them are published."""

    number: int = 0
    packets: list[bytes] = field(default_factory=list)
    size: int = 0
    published: int = 0

    @property
    def full(self) -> bool:
        """Tell whether only a key packet may follow."""
        return not self.packets or len(self.packets) > MOST_DELTAS or self.size > LONGEST


class Streams:
    """Takes packets from the driver in any thread, and publishes them in the thread that publishes states."""

    def __init__(self, slug: str, declared: tuple[Stream, ...], clock: Clock) -> None:
        self._slug, self._clock = slug, clock
        self._names = [stream.name for stream in declared]
        self._out = [_Outgoing() for _ in declared]
        self._lock = threading.Lock()
        self._refreshed, self._run = 0.0, 0

    def restart(self, epoch: int) -> None:
        """Take a key packet next, under this epoch: a new driver knows nothing of the packets of the last one."""
        with self._lock:
            self._run = epoch
            for one in self._out:
                one.packets, one.size, one.published = [], 0, 0

    def take(self, name: str, data: bytes, key: bool) -> bool:
        """Take the next packet; True if the one after it has to be a key packet. Asks no store.

        A delta without a key packet before it, or after too many deltas, is left out.

        Raises:
            ValueError: the spec declares no such stream, or the packet is too long.

        """
        if name not in self._names:
            raise ValueError(f"the spec declares no stream {name!r}")
        if len(data) > LONGEST:
            raise ValueError(f"a packet of {name!r} has {len(data)} bytes; at most {LONGEST} are possible")
        index = self._names.index(name)
        one, at_ms = self._out[index], int(self._clock.now().timestamp() * 1000)
        with self._lock:
            if key:
                one.packets, one.size, one.published = [], 0, 0
            elif one.full:
                return True
            one.number += 1
            one.packets.append(pack(StreamPacket(index, one.number, at_ms, key, bytes(data), self._run)))
            one.size += 0 if key else len(data)
            return one.full

    def publish(self) -> None:
        """Publish new packets; those that Redis does not take are tried again the next time."""
        refresh = bool(self._out) and self._clock.monotonic() - self._refreshed >= REFRESH_S
        if refresh:
            self._refreshed = self._clock.monotonic()
        for index, one in enumerate(self._out):
            if refresh and one.published and not bus.keep_stream(self._slug, index):
                one.published = 0  # Redis was away, and has lost it
            with self._lock:
                packets, first = one.packets, one.published
                new = packets[first:]
            if new and bus.publish_stream(self._slug, index, new, from_key=first == 0):
                with self._lock:
                    if one.packets is packets:
                        one.published = first + len(new)
