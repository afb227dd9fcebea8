"""The rover's Wi-Fi module: bytes between one client and the firmware, with delays and faults, whatever carries them.

A second client is refused while one is connected: its connection is closed at once, as the module does. Bytes of the
firmware are lost while nobody is connected. The firmware does not learn of a connection or of its end.
"""

import threading
from collections import deque
from collections.abc import Callable
from typing import Protocol

from robots.kit.clock import TIMER, Timer, Until
from robots.kit.drivers.srv1.extension import HOLD
from robots.kit.drivers.srv1.protocol import STOP
from simulators.common.faults import FaultBoard
from simulators.common.journal import Note

AHEAD_S = 0.25  # so much of the firmware's bytes the radio's modem buffers; then backpressure makes the firmware wait
MOST_LATE = 65536  # bytes that wait in each direction; more are lost
LOOK_S = 3600.0


class Peer(Protocol):
    """The module's end of a connection."""

    name: str

    def say(self, data: bytes) -> None:
        """Send bytes; where that fails, the connection ends by itself."""

    def cut(self) -> None:
        """End the connection at once."""


class Medium(Protocol):
    """A medium that carries bytes in place of Wi-Fi."""

    def reaches(self, farther: float, /) -> bool:
        """Return whether anything is heard; `farther`: m that the station is away in addition."""

    def arrival(self, now: float, size: int, /) -> float:
        """Return when so many bytes that are sent now have arrived; never before what was sent earlier, either way."""


class Link:
    """`receive` is the firmware's. Thread safe; its thread runs `run`."""

    def __init__(
        self, receive: Callable[[bytes], None], faults: FaultBoard, note: Note, clock: Timer = TIMER,
        medium: Medium | None = None,
    ) -> None:  # fmt: skip
        self._receive, self._faults, self._note, self._clock, self._medium = receive, faults, note, clock, medium
        self._changed = threading.Condition()
        self._present: Peer | None = None
        self._late: deque[tuple[float, bool, bytes]] = deque()  # when, whether to the firmware, what
        self._waits = {True: 0, False: 0}  # bytes, by direction
        self._runs = True

    # clients

    def join(self, peer: Peer) -> bool:
        """Accept a client; return False if there is another, which stays."""
        with self._changed:
            taken = self._present is None
            if taken:
                self._present = peer
        if taken:
            self._note("connected", peer=peer.name)
        else:
            self._note("refused", peer=peer.name, why="another client is connected")
        return taken

    def leave(self, peer: Peer) -> None:
        """Forget a client whose connection has ended; the firmware does not learn of it."""
        with self._changed:
            present = self._present is peer
            if present:
                self._present = None
        if present:
            self._note("disconnected", peer=peer.name)

    def take(self, peer: Peer, data: bytes) -> None:
        """Carry what the present client sends; ignore any other."""
        if self._present is not peer or self._is_cut():
            return
        if self._faults.value("flushed_hold") and (HOLD in data or data == STOP):
            self._faults.take("flushed_hold")
            data = data.replace(HOLD, b"") if HOLD in data else b""
        self._carry(data, to_robot=True)

    def say(self, data: bytes) -> float:
        """Carry what the firmware sends; return how long it has to wait (s): over a radio until most of it was sent."""
        if self._faults.value("mute") or self._is_cut():
            return 0.0
        return self._carry(data, to_robot=False)

    def power_off(self) -> None:
        """End the connection; bytes on their way are lost."""
        with self._changed:
            peer = self._present
            self._late.clear()
            self._waits = {True: 0, False: 0}
        if peer is not None:
            peer.cut()
            self.leave(peer)

    def close(self) -> None:
        """End the connection and the thread."""
        self.power_off()
        with self._changed:
            self._runs = False
            self._changed.notify_all()

    def _is_cut(self) -> bool:
        cut = bool(self._faults.take("cut"))
        if cut:
            self.power_off()
        return cut

    # bytes

    def _carry(self, data: bytes, to_robot: bool) -> float:
        faults, medium = self._faults, self._medium
        if faults.value("awol") or (medium is not None and not medium.reaches(faults.value("far"))):
            return 0.0
        data, now = faults.spoil(data), self._clock.monotonic()
        if not data:
            return 0.0
        with self._changed:
            due = now + faults.value("slow")
            due = due if medium is None else max(due, medium.arrival(now, len(data)))
            waits = self._waits[to_robot]
            late = due > now or waits > 0
            if late and waits + len(data) <= MOST_LATE + len(data) * (waits == 0):
                self._late.append((due, to_robot, data))
                self._waits[to_robot] += len(data)
                self._changed.notify_all()
        if not late:
            self._deliver(to_robot, data)
        return 0.0 if medium is None else max(0.0, due - now - AHEAD_S)

    def _deliver(self, to_robot: bool, data: bytes) -> None:
        if to_robot:
            self._receive(data)
        elif (peer := self._present) is not None:
            peer.say(data)

    def run(self) -> None:
        """Deliver delayed bytes, in order, until closed."""
        while True:
            with self._changed:
                due = self._late[0][0] if self._late else self._clock.monotonic() + LOOK_S
                first = self._late[0] if self._late else None
                left = max(0.0, due - self._clock.monotonic())
                self._clock.wait(Until(self._changed, lambda first=first: self._news(first)), left)  # type: ignore[misc]
                if not self._runs:
                    return
                if not self._late or self._late[0][0] > self._clock.monotonic():
                    continue
                _, to_robot, data = self._late.popleft()
            self._deliver(to_robot, data)
            with self._changed:
                self._waits[to_robot] = max(0, self._waits[to_robot] - len(data))

    def _news(self, first: tuple[float, bool, bytes] | None) -> bool:
        return not self._runs or (self._late[0] if self._late else None) is not first
