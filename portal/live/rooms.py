"""Who watches which robot, and what they are given: at once where the connection is free, else by their mailbox."""

import asyncio
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable
from typing import NamedTuple, TypeVar

import msgspec

from portal.edge.direct import Connection, binary_frame, text_frames
from portal.live.audience import Seat, audience
from portal.live.messages import CAMERAS, Watch
from portal.live.video import JOIN_S, LATER, Videos
from portal.live.watchers import Watchers, together, watchers_text
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.packet_chain import Cursor
from robots.kit.contract.video import unpack
from robots.kit.description import CODING
from robots.kit.packets import TAKEN_DOWN, Changed, Event

EVENTS = 100
SOUNDS = 5  # packets that wait for a viewer, a third of a second; older ones are left out
ALWAYS = ("events", "state", "stream")  # heard of every robot that has viewers
K = TypeVar("K")
Step = tuple[int, bool]  # a camera, and whether its pictures are coarse
Write = Callable[[bytes], None]
Group = dict["Viewer", Write | None]  # viewers that want the same; how to write at once to those that are ready for it


def _drop_empty(groups: dict[K, Group]) -> None:
    for key in [key for key, viewers in groups.items() if not viewers]:
        del groups[key]


class Viewer:
    """One socket's mailbox: each camera's newest picture, the newest state, a few events.

    With a `connection`, whatever finds the mailbox empty and the connection free is written at once; not before the
    mailbox was `emptied` for the first time. `wake` is set when something waits in the mailbox.
    """

    __slots__ = (
        "cameras", "coarse", "compact", "connection", "counted", "drives", "due", "events", "every_s", "frames",
        "given", "groups", "joins_from", "newest_from", "person", "resync", "seat", "slug", "sound", "sounds", "state",
        "stranger", "told", "trace", "video", "wake",
    )  # fmt: skip

    def __init__(self, slug: str, connection: Connection | None = None) -> None:
        self.slug, self.connection = slug, connection
        self.seat = Seat()  # counts what is sent to it alone
        self.groups: tuple[Group, ...] = ()  # in which it is
        self.stranger = False  # it is a page of somebody who is not signed in
        self.person, self.drives = 0, False  # whose page it is (key), as far as known; they drive
        self.trace = False
        self.cameras = frozenset({0})  # the cameras that it wants
        self.every_s = 0.0  # between two pictures of a camera, at least
        self.due: dict[int, float] = {}  # from when on it wants the next one, if not each
        self.compact = False  # it wants states in few bytes
        self.video, self.coarse = "", False  # the coding of video if it wants each picture so; it wants few bytes
        self.sound = False  # its person listens
        self.sounds: tuple[bytes, ...] = ()
        self.given: dict[int, Cursor] = {}  # of each camera's video
        self.newest_from = 0.0  # when it may be given the pictures that are kept
        self.joins_from = 0.0  # when it may be given all since the last key picture
        self.frames: dict[int, bytes] = {}
        self.state: bytes | None = None
        self.told: dict[int, Cursor] = {}  # of each byte stream
        self.events: deque[Event] = deque()
        self.resync = False
        self.counted = False  # it was not told yet how many watch
        self.wake = asyncio.Event()
        if connection is not None:
            connection.when_ready(self._readied)
            connection.keep(True)

    def enter(self, groups: Iterable[Group]) -> None:
        """Be in these groups from now on, and in no others."""
        for group in self.groups:
            group.pop(self, None)
        self.groups = tuple(groups)
        self._readied()

    def _readied(self) -> None:
        write = self.writer()
        for group in self.groups:
            group[self] = write

    def writer(self) -> Write | None:
        """Return how to write a frame at once; None if it may not be."""
        return self.connection.write if self.connection is not None and self.connection.ready else None

    def write(self, frame: bytes) -> None:
        """Write a frame to the connection, which there must be."""
        self.seat.sent_bytes += len(frame)
        self.connection.write(frame)  # type: ignore[union-attr]

    def write_text(self, text: str) -> None:
        """Write a text message to the connection, which there must be."""
        plain, compressed = text_frames(text)
        self.write(compressed if self.connection and self.connection.deflates else plain)

    def wait(self) -> None:
        """Something waits in the mailbox; nothing is written before it."""
        if self.connection is not None:
            self.connection.keep(True)
        self.wake.set()

    def emptied(self) -> None:
        """Nothing waits in the mailbox."""
        if self.connection is not None:
            self.connection.keep(False)

    def wish(self, wish: Watch) -> None:
        """Change what it wants; pictures that wait and are wanted no more are dropped."""
        cameras = self.cameras = frozenset(wish.cameras)
        self.every_s, self.compact = wish.every_s, wish.compact
        self.video, self.coarse = "" if wish.every_s else wish.video, wish.coarse and not wish.every_s
        self.sound, self.sounds = wish.sound, self.sounds if wish.sound else ()
        self.due.clear()
        now = SYSTEM.awake()  # whoever asks again and again does not get whole groups again and again
        if now < self.joins_from:
            self.given = dict.fromkeys(cameras, LATER)
        else:
            self.given, self.joins_from = {}, now + JOIN_S if self.video else self.joins_from
        for camera in self.frames.keys() - cameras:
            del self.frames[camera]

    def wants(self, camera: int) -> bool:
        """Return whether the next picture of a camera is due, of which it wants one now and then; taken as given."""
        now = SYSTEM.awake()
        if now < self.due.get(camera, 0.0):
            return False
        self.due[camera] = now + self.every_s
        return True

    def films(self, camera: int) -> bool:
        """Return whether it wants a camera's pictures as video."""
        return bool(self.video) and camera in self.cameras

    def ready(self) -> bool:
        """Return whether a frame may be written at once."""
        return self.connection is not None and self.connection.ready

    def put_event(self, event: Event) -> None:
        """Queue an event; if the queue is full, ask for a new snapshot instead."""
        if len(self.events) >= EVENTS:
            self.events.clear()
            self.resync = True
        self.events.append(event)
        self.wait()

    def put_picture(self, camera: int, data: bytes) -> None:
        """Replace the picture of a camera that waits."""
        self.frames[camera] = data
        self.wait()

    def put_sound(self, data: bytes) -> None:
        """Queue a packet of sound; the oldest gives way."""
        self.sounds = (*self.sounds, data)[-SOUNDS:]
        self.wait()

    def take_sounds(self) -> tuple[bytes, ...]:
        """Return the packets of sound that wait, and forget them."""
        taken, self.sounds = self.sounds, ()
        return taken


class Cameras(NamedTuple):
    """How many cameras a robot has, and the coding of their video."""

    many: int = CAMERAS
    coding: str = CODING


class Room:
    """Those who watch one robot, and what they are given."""

    def __init__(self, slug: str) -> None:
        self.slug = slug
        self.cameras = Cameras()  # that the robot has, where that is known
        self.viewers: dict[Viewer, None] = {}  # in the order in which they came
        self.each = defaultdict[Step, Group](dict)  # those that want each picture, by camera and step
        self.film = defaultdict[Step, Group](dict)  # those that want it as video
        self.some = defaultdict[int, Group](dict)  # those that want a camera's picture now and then
        self.listeners: Group = {}  # those that want sound
        self.states = defaultdict[bool, Group](dict)  # those that want compact states, or whole ones
        self.strangers = 0  # pages of people who are not signed in
        self.people = Counter[int]()  # pages of those who are and do not drive
        self.wanted = Counter[str]()  # how many want each camera's pictures, or the trace
        self.newest: dict[int, bytes] = {}  # each camera's picture
        self.videos = {coarse: Videos() for coarse in (False, True)}
        self.count = 0  # how many watch in all web processes together, when it was last counted
        self.asked = False  # the subscription was sent to Redis
        self.heard = asyncio.Event()  # Redis has confirmed that it sends what is told of this robot

    def add(self, viewer: Viewer) -> None:
        """Give a viewer, from now on, what it wants of this robot."""
        self.viewers[viewer] = None
        self._seat(viewer, 1)
        self.wanted.update(self._wants(viewer))
        viewer.enter(self._groups(viewer))

    def remove(self, viewer: Viewer) -> None:
        """Give a viewer nothing more; one that is not here is no error."""
        if viewer in self.viewers:
            del self.viewers[viewer]
            self._seat(viewer, -1)
            self.wanted.subtract(self._wants(viewer))
            viewer.enter(())
            for steps in (self.each, self.film):
                _drop_empty(steps)
            _drop_empty(self.some)

    def _seat(self, viewer: Viewer, many: int) -> None:
        self.strangers += many * viewer.stranger
        if viewer.person and not viewer.drives:
            self.people[viewer.person] += many
            self.people += Counter()  # forget those who have no page any more

    def here(self, now: int = 0) -> Watchers:
        """Return who watches in this process."""
        return Watchers(self.strangers, frozenset(self.people), now)

    def watching(self) -> int:
        """Return how many watch in all web processes, as far as this one knows."""
        return max(self.count, together([self.here()]))

    def cut(self, viewer: Viewer) -> None:
        """Leave out cameras, and a coding of video, that the robot does not have; before the viewer is added."""
        viewer.cameras = frozenset(camera for camera in viewer.cameras if camera < self.cameras.many)
        viewer.video = viewer.video if viewer.video == self.cameras.coding else ""

    def _groups(self, viewer: Viewer) -> list[Group]:
        if viewer.every_s:
            pictures = [self.some[camera] for camera in viewer.cameras]
        else:
            each = self.film if viewer.video else self.each
            pictures = [each[camera, viewer.coarse] for camera in viewer.cameras]
        return [self.states[viewer.compact], *pictures, *[self.listeners] * viewer.sound]

    def watched(self) -> frozenset[str]:
        """Return what somebody wants: names of cameras' streams, and `trace`."""
        return frozenset(what for what, many in self.wanted.items() if many > 0)

    def channels(self) -> set[str]:
        """Return the channels on which comes what somebody wants."""
        return {bus.channel_of(self.slug, what) for what in (*ALWAYS, *self.watched())}

    @staticmethod
    def _wants(viewer: Viewer) -> list[str]:
        return [
            *(
                bus.demand_for(camera, viewer.every_s, bool(viewer.video), viewer.coarse).name
                for camera in viewer.cameras
            ),
            *["trace"] * viewer.trace,
            *["compact"] * viewer.compact,
            *[bus.SOUND] * viewer.sound,
        ]

    def _write(self, group: Group, frame: bytes) -> list[Viewer]:
        """Write a frame to each connection that is ready for it; return the viewers to whom it was not written.

        This is what every picture costs for every viewer, so it looks at nothing but the group: with a thousand
        viewers, each further object of a viewer has to come from the machine's memory.
        """
        left = []
        for viewer, write in group.items():
            if write is not None:
                write(frame)
            else:
                left.append(viewer)
        if len(left) < len(group):
            audience().sent(self.slug, (len(group) - len(left)) * len(frame))
        return left

    def _write_some(self, viewers: Iterable[Viewer], frame: bytes) -> list[Viewer]:
        """Write a frame as `_write` does, to viewers who are no group."""
        return self._write({viewer: viewer.writer() for viewer in viewers}, frame)

    def _write_text(self, viewers: Iterable[Viewer], text: str) -> list[Viewer]:
        """Write a text message, as `_write` does."""
        plain, compressed = text_frames(text)
        sorts: tuple[list[Viewer], list[Viewer]] = ([], [])
        for viewer in viewers:
            sorts[viewer.connection is not None and viewer.connection.deflates].append(viewer)
        return self._write_some(sorts[False], plain) + self._write_some(sorts[True], compressed)

    def give_picture(self, camera: int, data: bytes, coarse: bool = False) -> None:
        """Give everybody who wants it a new picture."""
        if coarse:
            self.outdate(camera)
        else:
            self.newest[camera] = data
        each, some = self.each.get((camera, coarse)), None if coarse else self.some.get(camera)
        if not each and not some:
            return
        frame = binary_frame(data)
        left = self._write(each, frame) if each else []
        if some:
            left += self._write_some([viewer for viewer in some if viewer.wants(camera)], frame)
        for viewer in left:
            viewer.put_picture(camera, data)

    def give_video(self, data: bytes, coarse: bool) -> bool:
        """Give everybody who wants it the next packet of video; False if a key picture has to be asked for."""
        camera = unpack(data).camera
        self.outdate(camera)
        viewers = self.film.get((camera, coarse))
        if not viewers:  # it was wanted until now, or is in another web process
            self.videos[coarse].forget(camera)
            return True
        return self.videos[coarse].give(data, viewers, SYSTEM.awake())

    def outdate(self, camera: int) -> None:
        """Forget the newest JPEG if nobody here has new ones made: what comes now is newer."""
        if (camera, False) not in self.each and camera not in self.some:
            self.newest.pop(camera, None)

    def flows(self, viewer: Viewer, camera: int) -> bool:
        """Return whether a viewer who wants video can be given it at once."""
        return bool(viewer.video) and self.videos[viewer.coarse].flows(camera, SYSTEM.awake())

    def missing(self, viewer: Viewer) -> list[bytes]:
        """Return packets of video that a viewer has to be given now, and note that it was."""
        return self.videos[viewer.coarse].missing(viewer, SYSTEM.awake()) if viewer.video else []

    def keys(self) -> set[str]:
        """Return what has to be asked for so that everybody's video begins at once."""
        now, filmed = SYSTEM.awake(), [step for step, viewers in self.film.items() if viewers]
        return {
            bus.Demand(camera, video=True, coarse=coarse, key=True).name
            for camera, coarse in filmed
            if not self.videos[coarse].flows(camera, now)
        }

    def give_state(self, data: bytes, compact: bool) -> None:
        """Give a new state to everybody who wants them in this form."""
        if not self.states[compact]:
            return
        for viewer in self._write(self.states[compact], binary_frame(data)):
            viewer.state = data
            viewer.wait()

    def give_sound(self, data: bytes) -> None:
        """Give everybody who listens the next packet of sound."""
        if self.listeners:
            for viewer in self._write(self.listeners, binary_frame(data)):
                viewer.put_sound(data)

    def give_event(self, event: Event, trace: bool) -> None:
        """Give everybody an event; a line of the trace only to those who want it."""
        if event == TAKEN_DOWN:
            self.newest.clear()  # it may be among them
        viewers: Iterable[Viewer] = [v for v in self.viewers if v.trace] if trace else self.viewers
        if not isinstance(event, Changed):
            viewers = self._write_text(viewers, msgspec.json.encode(event).decode())
        for viewer in viewers:
            viewer.put_event(event)

    def give_packets(self, news: Callable[[Viewer], list[bytes]]) -> None:
        """Give everybody what is new for them of the byte streams."""
        for viewer in self.viewers:
            if viewer.ready():
                for packet in news(viewer):  # all of them: what follows a packet that is missing cannot be used
                    viewer.write(binary_frame(packet))
            else:
                viewer.wait()

    def give_count(self, count: int) -> None:
        """Tell everybody how many watch, where that has changed."""
        if count == self.count:
            return
        self.count = count
        for viewer in self._write_text(self.viewers, watchers_text(count)):
            viewer.counted = True
            viewer.wait()

    def wake(self) -> None:
        """Have everybody look into the mailbox."""
        for viewer in self.viewers:
            viewer.wait()
