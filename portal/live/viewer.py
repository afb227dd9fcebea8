"""One viewer of one robot: its wish, and a mailbox for messages that its connection cannot take at once."""

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

from portal.edge.direct import Connection
from portal.live.audience import Seat
from portal.live.messages import CAMERAS, Watch
from portal.live.video import VideoCursors
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.compact import FIRST as COMPACT
from robots.kit.contract.packet_chain import Cursor
from robots.kit.description import CODING
from robots.kit.packets import CommandStage, Event

EVENTS = 100
SOUNDS = 5  # packets that wait for a viewer, a third of a second; older ones are left out
SHORTEST = 40  # bytes of a piece of a long message
NEWEST_S = 1.0  # between two times that a viewer which changes its wish is given the newest pictures
STRANGER = -1  # as a visitor: a page of somebody who is not signed in
Write = Callable[[bytes], None]
Group = dict["Viewer", Write | None]  # viewers that want the same; how to write at once to those that are ready for it


class Cameras(NamedTuple):
    """How many cameras a robot has, and the coding of their video."""

    many: int = CAMERAS
    coding: str = CODING


@dataclass(frozen=True)
class Wish:
    """The wish of a viewer: pictures of which cameras, each or one in `every_s` seconds; the form of states; sound.

    If it wants each picture, `video` is the coding in which it wants them (empty: JPEG); `coarse`: in few bytes. Who
    wants compact states has a slow line, on which little may be on the way; with `pieces` it takes long messages in
    pieces, between which others come.
    """

    cameras: frozenset[int] = frozenset({0})
    every_s: float = 0.0
    compact: bool = False
    video: str = ""
    coarse: bool = False
    sound: bool = False
    pieces: bool = False

    @classmethod
    def of(cls, message: Watch) -> "Wish":
        """Return what a page asks for."""
        each = not message.every_s
        video, coarse = message.video if each else "", message.coarse and each
        return cls(
            frozenset(message.cameras), message.every_s, message.compact, video, coarse, message.sound, message.pieces
        )

    def within(self, cameras: Cameras) -> "Wish":
        """Return the wish without cameras, and without a coding of video, that the robot does not have."""
        known = frozenset(camera for camera in self.cameras if camera < cameras.many)
        return replace(self, cameras=known, video=self.video if self.video == cameras.coding else "")

    @property
    def demands(self) -> list[str]:
        """Return the names of its demands."""
        pictures = (bus.demand_for(camera, self.every_s, bool(self.video), self.coarse) for camera in self.cameras)
        return [*(demand.name for demand in pictures), *["compact"] * self.compact, *[bus.SOUND] * self.sound]


class Viewer:
    """A viewer with its mailbox: each camera's newest picture, the newest state and path, a few events, some sound.

    With a `connection`, a message is written at once if the mailbox is empty and the connection is free, but not before
    the first `set_empty`. Without one, the owner of the viewer takes everything from the mailbox.

    `visitor`: as whom it is counted among the watchers: the key of a person, STRANGER, or 0 for nobody.
    `trace`: it shows the wire trace. `seat` counts the bytes that are sent to it alone.
    """

    __slots__ = (
        "_count", "_due", "_events", "_groups", "_mail", "_newest_from", "_packed", "_path", "_pictures", "_snapshot",
        "_sounds", "_state", "_whole", "connection", "seat", "slug", "stream_cursors", "trace", "video_cursors",
        "visitor", "wish",
    )  # fmt: skip

    def __init__(self, slug: str, connection: Connection | None = None, wish: Wish = Wish()) -> None:
        self.slug, self.connection, self.wish = slug, connection, wish
        self.seat, self.visitor, self.trace = Seat(), 0, False
        self.video_cursors = VideoCursors()  # by camera
        self.stream_cursors: dict[int, Cursor] = {}  # by byte stream
        self._groups: tuple[Group, ...] = ()  # in which it is
        self._due: dict[int, float] = {}  # when a camera's next picture is due, if it does not want each
        self._newest_from = 0.0  # when it may be given the newest pictures again
        self._pictures: dict[int, bytes] = {}
        self._state: bytes | None = None
        self._whole: bytes | None = None  # a whole state, while compact ones come
        self._packed = False  # compact states come
        self._path: bytes | None = None
        self._sounds: deque[bytes] = deque(maxlen=SOUNDS)
        self._events: deque[Event] = deque()
        self._snapshot = self._count = False  # it needs a new snapshot; it needs the number of watchers
        self._mail = asyncio.Event()  # set when something waits in the mailbox
        if connection is not None:
            connection.when_ready(self._update_groups)
            connection.keep(True)

    # its wish

    def choose(self, wish: Wish) -> None:
        """Change its wish; pictures that wait and are wanted no more are dropped."""
        self.wish = wish
        if self.connection is not None:
            self.connection.bound(wish.compact)
            self.connection.remember(wish.compact and wish.pieces)  # all its messages go through its writer then
        self.video_cursors.restart(wish.cameras, bool(wish.video), SYSTEM.awake())
        self._due.clear()
        if not wish.sound:
            self._sounds.clear()
        for camera in self._pictures.keys() - wish.cameras:
            del self._pictures[camera]

    def films(self, camera: int) -> bool:
        """Return whether it wants a camera's pictures as video."""
        return bool(self.wish.video) and camera in self.wish.cameras

    def wants(self, camera: int) -> bool:
        """Return whether a picture of a camera is due, one in `every_s`; if it is, it counts as sent."""
        now = SYSTEM.awake()
        if now < self._due.get(camera, 0.0):
            return False
        self._due[camera] = now + self.wish.every_s
        return True

    # messages that are written at once

    def enter(self, groups: Iterable[Group]) -> None:
        """Be in these groups from now on, and in no others."""
        for group in self._groups:
            group.pop(self, None)
        self._groups = tuple(groups)
        self._update_groups()

    def _update_groups(self) -> None:
        write = self.writer()
        for group in self._groups:
            group[self] = write

    def writer(self) -> Write | None:
        """Return how to write a frame at once; None if it may not be."""
        return self.connection.write if self.connection is not None and self.ready() else None

    def ready(self) -> bool:
        """Return whether a frame may be written at once; over a thin line it waits for more important ones."""
        return self.connection is not None and self.connection.ready and not (self.wish.pieces and self.wish.compact)

    @property
    def deflates(self) -> bool:
        """Return whether it reads compressed texts."""
        return self.connection is not None and self.connection.deflates

    @property
    def piece(self) -> int:
        """Return how long a message may be that holds up others (bytes); 0: any length."""
        window = self.connection.window if self.connection is not None and self.wish.pieces else 0
        return max(SHORTEST, window) if window else 0

    def write(self, frame: bytes) -> None:
        """Write a frame to the connection, which there must be."""
        self.seat.sent_bytes += len(frame)
        self.connection.write(frame)  # type: ignore[union-attr]

    def write_urgent(self, frame: bytes) -> bool:
        """Write a frame over a thin line whatever is on the way, as answers are; False if it has to be put instead."""
        if not self.piece or self.connection is None or self.connection.is_closing():
            return False
        self.write(frame)
        return True

    def write_message(self, message: str | bytes) -> None:
        """Write a message, over a thin line compressed, to the connection, which there must be."""
        self.write(self.connection.frame(message))  # type: ignore[union-attr]

    def size(self, message: str | bytes) -> int:
        """Return how many bytes it would take on the connection, which there must be."""
        return self.connection.size(message)  # type: ignore[union-attr]

    # messages that are put into the mailbox

    def wake(self) -> None:
        """Ask the writer to empty the mailbox; nothing is written before its messages."""
        if self.connection is not None:
            self.connection.keep(True)
        self._mail.set()

    def put_picture(self, camera: int, data: bytes) -> None:
        """Replace the picture of a camera that waits."""
        self._pictures[camera] = data
        self.wake()

    def put_newest(self, pictures: dict[int, bytes]) -> None:
        """Put the newest pictures, by camera; they may be old, so they do not delay the next ones."""
        now = SYSTEM.awake()
        if pictures and now >= self._newest_from:
            self._newest_from = now + NEWEST_S
            for camera, data in pictures.items():
                self.put_picture(camera, data)

    def put_state(self, data: bytes) -> None:
        """Replace the state that waits; over a thin line a whole one between compact ones is less urgent."""
        self._packed = self._packed or data[0] >= COMPACT
        if self.piece and self._packed and data[0] < COMPACT:
            self._whole = data
        else:
            self._state = data
        self.wake()

    def put_path(self, data: bytes | None) -> None:
        """Replace the path that waits; None: it is told no more."""
        self._path = data
        if data is not None:
            self.wake()

    def put_sound(self, data: bytes) -> None:
        """Queue a packet of sound; the oldest is dropped if too many wait."""
        self._sounds.append(data)
        self.wake()

    def put_event(self, event: Event) -> None:
        """Queue an event; if the queue is full, ask for a new snapshot instead.

        Over a thin line the newest stage of a command takes the place of one that waits.
        """
        if self.wish.pieces and isinstance(event, CommandStage):
            self._events = deque(e for e in self._events if not isinstance(e, CommandStage) or e.id != event.id)
        if len(self._events) >= EVENTS:
            self._events.clear()
            self._snapshot = True
        self._events.append(event)
        self.wake()

    def ask_snapshot(self) -> None:
        """Note that it needs a new snapshot."""
        self._snapshot = True
        self.wake()

    def ask_count(self) -> None:
        """Note that it needs the number of watchers."""
        self._count = True
        self.wake()

    # messages that are taken from the mailbox

    async def wait_for_mail(self, within_s: float) -> None:
        """Wait until something has come into the mailbox, or for so long."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(within_s):  # wait_for may lose a cancellation
                await self._mail.wait()
        self._mail.clear()

    def take_signal(self) -> bool:
        """Return whether something has come since this, or `wait_for_mail`, was called last."""
        came = self._mail.is_set()
        self._mail.clear()
        return came

    def set_empty(self) -> None:
        """Note that nothing waits in the mailbox."""
        if self.connection is not None:
            self.connection.keep(False)

    def take_picture(self, camera: int | None = None) -> bytes | None:
        """Return the picture of a camera, or the one that waits longest; None if there is none."""
        if camera is None:
            camera = next(iter(self._pictures), 0)
        return self._pictures.pop(camera, None)

    def take_state(self) -> bytes | None:
        """Return the state that waits; None if there is none."""
        state, self._state = self._state, None
        return state

    def take_whole(self) -> bytes | None:
        """Return the whole state that waits and is not urgent; None if there is none."""
        whole, self._whole = self._whole, None
        return whole

    def take_path(self) -> bytes | None:
        """Return the path that waits; None if there is none."""
        path, self._path = self._path, None
        return path

    def take_sounds(self) -> list[bytes]:
        """Return the packets of sound that wait."""
        sounds = list(self._sounds)
        self._sounds.clear()
        return sounds

    def take_event(self) -> Event | None:
        """Return the oldest event; None if there is none."""
        return self._events.popleft() if self._events else None

    def drop_events(self) -> None:
        """Forget the events that wait."""
        self._events.clear()

    def take_requests(self) -> tuple[bool, bool]:
        """Return whether it needs a new snapshot, and whether it needs the number of watchers."""
        asked, self._snapshot, self._count = (self._snapshot, self._count), False, False
        return asked
