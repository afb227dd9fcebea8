"""Who watches which robot, and what they are given: at once where the connection is free, else by their mailbox."""

import asyncio
import time
from collections import Counter, deque

import msgspec

from portal.live.audience import Seat
from portal.live.direct import Connection, binary_frame, text_frames
from portal.live.messages import Watch
from portal.live.video import JOIN_S, NEXT, Given, Videos
from robots import bus
from robots.messages import Changed, Event

EVENTS = 100


def watchers_text(count: int) -> str:
    """Return the message that tells how many watch."""
    return f'{{"t": "watchers", "count": {count}}}'


class Viewer:
    """One socket's mailbox: each camera's newest picture, the newest state, a few events.

    With a `connection`, and once it is `direct`, whatever finds the mailbox empty and the connection free is written at
    once. `wake` is set when something waits in the mailbox.
    """

    __slots__ = (
        "cameras", "coarse", "compact", "connection", "counted", "direct", "due", "events", "every_s", "frames",
        "given", "joins_from", "page", "resync", "seat", "slug", "state", "stranger", "told", "trace", "video", "wake",
    )  # fmt: skip

    def __init__(self, slug: str, connection: Connection | None = None) -> None:
        self.slug, self.connection = slug, connection
        self.seat = Seat()  # counts what is sent
        self.direct = False
        self.page = self.stranger = False  # a page shows it, of somebody who is not signed in
        self.trace = False
        self.cameras = frozenset({0})  # the cameras that it wants
        self.every_s = 0.0  # between two pictures of a camera, at least
        self.due: dict[int, float] = {}  # from when on it wants the next one, if not each
        self.compact = False  # it wants states in few bytes
        self.video = self.coarse = False  # it wants each picture as video, or in few bytes
        self.given: dict[int, Given] = {}  # of each camera's video
        self.joins_from = 0.0  # when it may be given all since the last key picture
        self.frames: dict[int, bytes] = {}
        self.state: bytes | None = None
        self.told: dict[int, tuple[list[bytes], int]] = {}  # of each byte stream: which key packet's, how many
        self.events: deque[Event] = deque()
        self.resync = False
        self.counted = False  # it was not told yet how many watch
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

    def wish(self, wish: Watch) -> None:
        """Change what it wants; pictures that wait and are wanted no more are dropped."""
        cameras = self.cameras = frozenset(wish.cameras)
        self.every_s, self.compact = wish.every_s, wish.compact
        self.video, self.coarse = bool(wish.video) and not wish.every_s, wish.coarse and not wish.every_s
        self.due.clear()
        now = time.monotonic()  # whoever asks again and again does not get whole groups again and again
        self.given = {} if now >= self.joins_from else dict.fromkeys(cameras, NEXT)
        if self.video:
            self.joins_from = now + JOIN_S
        for camera in self.frames.keys() - cameras:
            del self.frames[camera]

    def wants(self, camera: int) -> bool:
        """Return whether it wants a new picture of that camera; then it is taken as given."""
        if camera not in self.cameras or self.video:
            return False
        if self.every_s:
            now = time.monotonic()
            if now < self.due.get(camera, 0.0):
                return False
            self.due[camera] = now + self.every_s
        return True

    def films(self, camera: int) -> bool:
        """Return whether it wants a camera's pictures as video."""
        return self.video and camera in self.cameras

    def look(self) -> None:
        """Have it look soon for video that it was not given yet."""
        self.wake.set()

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
        self.pages = self.strangers = 0  # of these viewers
        self.wanted = Counter[str]()  # how many want each camera's pictures, or the trace
        self.newest: dict[int, bytes] = {}  # each camera's picture
        self.videos = {coarse: Videos() for coarse in (False, True)}
        self.count = 0  # how many watch in all web processes together, when it was last counted
        self.asked = False  # the subscription was sent to Redis
        self.heard = asyncio.Event()  # Redis has confirmed that it sends what is told of this robot

    def add(self, viewer: Viewer) -> None:
        """Add a viewer."""
        self.viewers.add(viewer)
        self.pages += viewer.page
        self.strangers += viewer.stranger
        self.wanted.update(self._wants(viewer))

    def remove(self, viewer: Viewer) -> None:
        """Remove a viewer."""
        if viewer in self.viewers:
            self.viewers.remove(viewer)
            self.pages -= viewer.page
            self.strangers -= viewer.stranger
            self.wanted.subtract(self._wants(viewer))

    def watched(self) -> frozenset[str]:
        """Return what somebody wants: names of cameras' streams, and `trace`."""
        return frozenset(what for what, many in self.wanted.items() if many > 0)

    @staticmethod
    def _wants(viewer: Viewer) -> list[str]:
        return [
            *(bus.watched_as(camera, viewer.every_s, viewer.video, viewer.coarse) for camera in viewer.cameras),
            *["trace"] * viewer.trace,
            *["compact"] * viewer.compact,
        ]

    def give_picture(self, camera: int, data: bytes, coarse: bool = False) -> None:
        """Give everybody who wants it a new picture."""
        if not coarse:
            self.newest[camera] = data
        frame = binary_frame(data)
        for viewer in self.viewers:
            if viewer.coarse is not coarse or not viewer.wants(camera):
                continue
            if viewer.ready():
                viewer.write(frame)
            else:
                viewer.put_picture(camera, data)

    def give_video(self, data: bytes, coarse: bool) -> bool:
        """Give everybody who wants it the next packet of video; False if a key picture has to be asked for."""
        viewers = (viewer for viewer in self.viewers if viewer.coarse is coarse)
        return self.videos[coarse].give(data, viewers, time.monotonic())

    def flows(self, viewer: Viewer, camera: int) -> bool:
        """Return whether a viewer who wants video can be given it at once."""
        return viewer.video and self.videos[viewer.coarse].flows(camera, time.monotonic())

    def missing(self, viewer: Viewer) -> list[bytes]:
        """Return packets of video that a viewer has to be given now, and note that it was."""
        return self.videos[viewer.coarse].missing(viewer, time.monotonic()) if viewer.video else []

    def keys(self) -> set[str]:
        """Return what has to be asked for so that everybody's video begins at once."""
        filmed = [(viewer, camera) for viewer in self.viewers if viewer.video for camera in viewer.cameras]
        return {bus.key_of(camera, viewer.coarse) for viewer, camera in filmed if not self.flows(viewer, camera)}

    def give_state(self, data: bytes, compact: bool) -> None:
        """Give a new state to everybody who wants them in this form."""
        frame = binary_frame(data)
        for viewer in self.viewers:
            if viewer.compact is not compact:
                continue
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

    def give_count(self, count: int) -> None:
        """Tell everybody how many watch, where that has changed."""
        if count == self.count:
            return
        self.count = count
        for viewer in self.viewers:
            if viewer.ready():
                viewer.write_text(watchers_text(count))
            else:
                viewer.counted = True
                viewer.wake.set()

    def wake(self) -> None:
        """Have everybody look into the mailbox."""
        for viewer in self.viewers:
            viewer.wake.set()
