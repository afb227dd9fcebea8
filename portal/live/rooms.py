"""The viewers of one robot: a message is written to a free connection at once, else it waits in the mailbox."""

import asyncio
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from typing import TypeVar

import msgspec

from portal.edge.compression import text_frames
from portal.edge.direct import binary_frame
from portal.live.audience import Audience
from portal.live.cheers import Cheers
from portal.live.video import Videos
from portal.live.viewer import STRANGER, Cameras, Group, Viewer
from portal.live.watchers import Watchers, together, watchers_text
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.path_packet import COMMANDS, command_of, seconds_of
from robots.kit.packets import TAKEN_DOWN, Changed, CommandStage, Event
from robots.states import COMMAND_FINAL

ALWAYS = ("events", "state", "stream", "path")  # heard of every robot that has viewers
K = TypeVar("K")
Step = tuple[int, bool]  # a camera, and whether its pictures are coarse


def _drop_empty(groups: dict[K, Group]) -> None:
    for key in [key for key, viewers in groups.items() if not viewers]:
        del groups[key]


class Room:
    """The viewers of one robot in this process, grouped by their wishes, and the newest pictures and video for them."""

    def __init__(self, slug: str, audience: Audience | None = None) -> None:
        self.slug, self._audience = slug, audience or Audience()
        self.cameras = Cameras()  # that the robot has, where that is known
        self.viewers: dict[Viewer, None] = {}  # in the order in which they came
        self.each = defaultdict[Step, Group](dict)  # those that want each picture, by camera and step
        self.film = defaultdict[Step, Group](dict)  # those that want it as video
        self.some = defaultdict[int, Group](dict)  # those that want a camera's picture now and then
        self.listeners: Group = {}  # those that want sound
        self.states = defaultdict[bool, Group](dict)  # those that want compact states, or whole ones
        self.strangers = 0  # pages of people who are not signed in
        self.people = Counter[int]()  # pages of people who are signed in and do not drive
        self.demand = Counter[str]()  # how many want each camera's pictures, or the trace
        self.newest: dict[int, bytes] = {}  # each camera's picture
        self._path, self._path_until = b"", 0.0  # on which the robot moves, and until when that is told
        self.videos = {coarse: Videos() for coarse in (False, True)}
        self.count = 0  # how many watch in all web processes together, when it was last counted
        self.cheers = Cheers()
        self.requested = False  # the subscription was sent to Redis
        self.confirmation = asyncio.Event()  # set when Redis has confirmed the subscription

    def add(self, viewer: Viewer) -> None:
        """Add a viewer to the groups of its wish."""
        self.viewers[viewer] = None
        self._seat(viewer, 1)
        self.demand.update(self._demands(viewer))
        viewer.enter(self._groups(viewer))

    def remove(self, viewer: Viewer) -> None:
        """Remove a viewer; one that is not here is no error."""
        if viewer in self.viewers:
            del self.viewers[viewer]
            self._seat(viewer, -1)
            self.demand.subtract(self._demands(viewer))
            viewer.enter(())
            for steps in (self.each, self.film):
                _drop_empty(steps)
            _drop_empty(self.some)

    def _seat(self, viewer: Viewer, many: int) -> None:
        if viewer.visitor == STRANGER:
            self.strangers += many
        elif viewer.visitor:
            self.people[viewer.visitor] += many
            self.people += Counter()  # drop zeros

    def here(self, now: int = 0) -> Watchers:
        """Return the people and strangers who watch in this process."""
        return Watchers(self.strangers, frozenset(self.people), now)

    def watching(self) -> int:
        """Return how many watch in all web processes, as far as this one knows."""
        return max(self.count, together([self.here()]))

    def _groups(self, viewer: Viewer) -> list[Group]:
        wish = viewer.wish
        if wish.every_s:
            pictures = [self.some[camera] for camera in wish.cameras]
        else:
            each = self.film if wish.video else self.each
            pictures = [each[camera, wish.coarse] for camera in wish.cameras]
        return [self.states[wish.compact], *pictures, *[self.listeners] * wish.sound]

    def watched(self) -> frozenset[str]:
        """Return the names of the demands that somebody has."""
        return frozenset(what for what, many in self.demand.items() if many > 0)

    def channels(self) -> set[str]:
        """Return the channels of these demands, and those that are always heard."""
        return {bus.channel_of(self.slug, what) for what in (*ALWAYS, *self.watched())}

    @staticmethod
    def _demands(viewer: Viewer) -> list[str]:
        return [*viewer.wish.demands, *["trace"] * viewer.trace]

    def _write(self, group: Group, frame: bytes) -> list[Viewer]:
        """Write a frame to each connection that is ready for it; return the viewers to whom it was not written.

        It runs for every picture and every viewer, so it reads nothing but the group: with a thousand viewers, each
        further object of a viewer would have to be fetched from main memory.
        """
        left = []
        for viewer, write in group.items():
            if write is not None:
                write(frame)
            else:
                left.append(viewer)
        if len(left) < len(group):
            self._audience.add_sent(self.slug, (len(group) - len(left)) * len(frame))
        return left

    def _write_some(self, viewers: Iterable[Viewer], frame: bytes) -> list[Viewer]:
        """Write a frame as `_write` does, to viewers that are not one group."""
        return self._write({viewer: viewer.writer() for viewer in viewers}, frame)

    def _write_text(self, viewers: Iterable[Viewer], text: str) -> list[Viewer]:
        """Write a text message, as `_write` does."""
        plain, compressed = text_frames(text)
        sorts: tuple[list[Viewer], list[Viewer]] = ([], [])
        for viewer in viewers:
            sorts[viewer.deflates].append(viewer)
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

    def give_video(self, camera: int, data: bytes, coarse: bool) -> bool:
        """Give everybody who wants it a camera's next packet of video; False if a key frame has to be asked for."""
        self.outdate(camera)
        viewers = self.film.get((camera, coarse))
        if not viewers:  # it was wanted until now, or is in another web process
            self.videos[coarse].forget(camera)
            return True
        return self.videos[coarse].give(camera, data, viewers, SYSTEM.awake())

    def outdate(self, camera: int) -> None:
        """Forget the newest JPEG if nobody here wants JPEG: pictures of another form are newer now."""
        if (camera, False) not in self.each and camera not in self.some:
            self.newest.pop(camera, None)

    def flows(self, viewer: Viewer, camera: int) -> bool:
        """Return whether a viewer who wants video can be given it at once."""
        wish = viewer.wish
        return bool(wish.video) and self.videos[wish.coarse].flows(camera, SYSTEM.awake())

    def take_missing(self, viewer: Viewer) -> list[bytes]:
        """Return packets of video that a viewer has to be given now, and note that it was."""
        wish = viewer.wish
        return self.videos[wish.coarse].take_missing(viewer, SYSTEM.awake()) if wish.video else []

    def give_newest(self, viewer: Viewer) -> None:
        """Give a viewer the newest JPEG of each camera that it wants, where its video cannot begin at once."""
        if not viewer.wish.coarse:  # the newest pictures are not coarse
            kept = self.newest.items()
            viewer.put_newest({c: data for c, data in kept if c in viewer.wish.cameras and not self.flows(viewer, c)})

    def keys(self) -> set[str]:
        """Return the demands for key frames without which somebody's video cannot begin."""
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
            viewer.put_state(data)

    def give_path(self, data: bytes) -> None:
        """Give everybody the path on which the robot begins to move. Raises ValueError."""
        self._path, self._path_until = data, SYSTEM.awake() + seconds_of(data)
        frame = binary_frame(data)
        for viewer in self._write_some(self.viewers, frame):
            if not viewer.write_urgent(frame):
                viewer.put_path(data)

    def give_running_path(self, viewer: Viewer) -> None:
        """Give a viewer that has come the path on which the robot moves already."""
        if self._path and SYSTEM.awake() < self._path_until:
            viewer.put_path(self._path)

    def _end_path(self, event: Event) -> None:
        """Forget the path of a command that has ended: nobody may be told it as one that runs."""
        if not self._path or not isinstance(event, CommandStage) or event.state not in COMMAND_FINAL:
            return
        if command_of(self._path) == event.id % COMMANDS:
            self._path = b""
            for viewer in self.viewers:
                viewer.put_path(None)

    def give_sound(self, data: bytes) -> None:
        """Give everybody who listens the next packet of sound."""
        if self.listeners:
            for viewer in self._write(self.listeners, binary_frame(data)):
                viewer.put_sound(data)

    def give_event(self, event: Event, trace: bool) -> None:
        """Give everybody an event; a line of the trace only to those who want it."""
        self._end_path(event)
        if event == TAKEN_DOWN:
            self.newest.clear()  # the picture may be among them
        viewers: Iterable[Viewer] = [v for v in self.viewers if v.trace] if trace else self.viewers
        if not isinstance(event, Changed):
            viewers = self._write_text(viewers, msgspec.json.encode(event).decode())
        for viewer in viewers:
            viewer.put_event(event)

    def give_packets(self, news: Callable[[Viewer], list[bytes]]) -> None:
        """Give everybody the packets of byte streams that are new for them."""
        for viewer in self.viewers:
            if viewer.ready():
                for packet in news(viewer):  # all of them: a delta is of no use without the packet before it
                    viewer.write(binary_frame(packet))
            else:
                viewer.wake()

    def give_count(self, count: int) -> None:
        """Tell everybody how many watch, where that has changed."""
        if count == self.count:
            return
        self.count = count
        for viewer in self._write_text(self.viewers, watchers_text(count)):
            viewer.ask_count()

    def give_cheers(self, grant: int, new: int, count: int) -> None:
        """Note that Redis has so many new cheers, and tell everybody how many there are, where that has changed."""
        if self.cheers.note_count(grant, new, count) and (text := self.cheers.text()):
            for viewer in self._write_text(self.viewers, text):
                viewer.ask_count()

    def wake(self) -> None:
        """Ask all writers to empty the mailboxes."""
        for viewer in self.viewers:
            viewer.wake()
