"""Who watches which robot, and what they are given: at once where the connection is free, else by their mailbox."""

import asyncio
from collections import Counter, deque

import msgspec

from portal.live.audience import Seat
from portal.live.direct import Connection, binary_frame, text_frames
from robots import bus
from robots.messages import Changed, Event

EVENTS = 100


class Viewer:
    """One socket's mailbox: each camera's newest picture, the newest state, a few events.

    With a `connection`, and once it is `direct`, whatever finds the mailbox empty and the connection free is written at
    once. `wake` is set when something waits in the mailbox.
    """

    __slots__ = (
        "cameras", "connection", "direct", "events", "frames", "link", "resync", "seat", "slug", "state", "told",
        "trace", "wake",
    )  # fmt: skip

    def __init__(self, slug: str, connection: Connection | None = None) -> None:
        self.slug, self.connection = slug, connection
        self.seat = Seat()  # counts what is sent
        self.direct = False
        self.trace = False
        self.link = True
        self.cameras = frozenset({0})  # the cameras that it wants
        self.frames: dict[int, bytes] = {}
        self.state: bytes | None = None
        self.told: dict[int, tuple[list[bytes], int]] = {}  # of each byte stream: which key packet's, how many
        self.events: deque[Event] = deque()
        self.resync = False
        self.wake = asyncio.Event()

    def ready(self) -> bool:
        """Return whether a frame may be written at once: nothing waits before it."""
        return self.direct and not self.wake.is_set() and self.connection is not None and self.connection.free()

    def write(self, frame: bytes) -> None:
        """Write a frame; only when it is `ready`."""
        self.seat.sent_bytes += len(frame)
        self.connection.write(frame)  # type: ignore[union-attr]

    def write_text(self, text: str) -> None:
        """Write a text message; only when it is `ready`."""
        plain, compressed = text_frames(text)
        self.write(compressed if self.connection and self.connection.deflates else plain)

    def put_event(self, event: Event) -> None:
        """Queue an event; if the queue is full, ask for a new snapshot instead."""
        if len(self.events) >= EVENTS:
            self.events.clear()
            self.resync = True
        self.events.append(event)
        self.wake.set()

    def put_picture(self, camera: int, data: bytes) -> None:
        """Replace the picture of a camera that waits."""
        self.frames[camera] = data
        self.wake.set()


class Room:
    """Those who watch one robot, and what they are given."""

    def __init__(self) -> None:
        self.viewers: set[Viewer] = set()
        self.wanted = Counter[str]()  # how many want each camera's pictures, or the trace
        self.newest: dict[int, bytes] = {}  # each camera's picture
        self.heard = asyncio.Event()  # Redis has confirmed that it sends what is told of this robot

    def add(self, viewer: Viewer) -> None:
        """Add a viewer."""
        self.viewers.add(viewer)
        self.wanted.update(self._wants(viewer))

    def remove(self, viewer: Viewer) -> None:
        """Remove a viewer."""
        if viewer in self.viewers:
            self.viewers.remove(viewer)
            self.wanted.subtract(self._wants(viewer))

    def watched(self) -> frozenset[str]:
        """Return what somebody wants: names of cameras' streams, and `trace`."""
        return frozenset(what for what, many in self.wanted.items() if many > 0)

    @staticmethod
    def _wants(viewer: Viewer) -> list[str]:
        return [*map(bus.frames_of, viewer.cameras), *(["trace"] if viewer.trace else [])]

    def give_picture(self, camera: int, data: bytes) -> None:
        """Give everybody who wants it a new picture."""
        self.newest[camera] = data
        frame = binary_frame(data)
        for viewer in self.viewers:
            if camera not in viewer.cameras:
                continue
            if viewer.ready():
                viewer.write(frame)
            else:
                viewer.put_picture(camera, data)

    def give_state(self, data: bytes) -> None:
        """Give everybody a new state."""
        frame = binary_frame(data)
        for viewer in self.viewers:
            if viewer.ready():
                viewer.write(frame)
            else:
                viewer.state = data
                viewer.wake.set()

    def give_event(self, event: Event, trace: bool) -> None:
        """Give everybody an event; a line of the trace only to those who want it."""
        again = isinstance(event, Changed)
        text = "" if again else msgspec.json.encode(event).decode()
        for viewer in self.viewers:
            if trace and not viewer.trace:
                continue
            if not again and viewer.ready():
                viewer.write_text(text)
            else:
                viewer.put_event(event)

    def wake(self) -> None:
        """Have everybody look into the mailbox."""
        for viewer in self.viewers:
            viewer.wake.set()
