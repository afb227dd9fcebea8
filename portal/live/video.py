"""A camera's video for each viewer: the same packets for all, never one without those that it changes.

A process keeps the packets since the last key frame. A newcomer gets them at once. A viewer that falls behind is given
the missing ones if they are short or no more bytes than a key frame; otherwise it waits for the next key frame.
"""

from collections.abc import Iterable
from typing import Protocol

from portal.edge.direct import binary_frame
from robots.kit.contract.packet_chain import START, Cursor, PacketChain
from robots.kit.contract.video import GROUP_S, unpack

LATE_MS = 500  # missed packets that cover no more than this are sent, however many bytes they are
SILENT_S = GROUP_S + 0.5  # after such a silence the next packet follows none of those that are kept
JOIN_S = 1.0  # between two times that a viewer is given all since the last key frame, at least
NEXT = Cursor([], -1)  # the viewer has to wait for the next key frame
LATER = Cursor([], -2)  # or until it may be given all since the last one again


class VideoCursors(dict[int, Cursor]):
    """How far one viewer was given each camera's video; a camera without a cursor has just been asked for."""

    joins_from = 0.0  # when it may be given all since the last key frame (s)

    def restart(self, cameras: Iterable[int], video: bool, now: float) -> None:
        """Begin anew because the viewer wants something else, these cameras as `video` or not.

        A viewer that asks again and again is not sent a whole group each time.
        """
        self.clear()
        if now < self.joins_from:
            self.update(dict.fromkeys(cameras, LATER))
        elif video:
            self.joins_from = now + JOIN_S


class Watcher(Protocol):
    """The methods of a viewer that are used here."""

    video_cursors: VideoCursors

    def films(self, camera: int) -> bool:
        """Return whether it wants video of a camera."""

    def ready(self) -> bool:
        """Return whether a frame may be written at once."""

    def write(self, frame: bytes) -> None:
        """Write a frame."""

    def wake(self) -> None:
        """Ask it to fetch the packets that it does not have yet; nothing is written before them."""


class Videos:
    """The video of one robot's cameras since their last key frames. `now` is monotonic (s)."""

    def __init__(self) -> None:
        self._chains: dict[int, PacketChain] = {}
        self._heard: dict[int, float] = {}  # when the newest packet of each camera came
        self._asked: set[int] = set()  # cameras of which a key frame is needed

    def give(self, camera: int, data: bytes, viewers: Iterable[Watcher], now: float) -> bool:
        """Give a camera's new packet to those who want it; False if a key frame has to be asked for.

        Raises ValueError.
        """
        chain = self._chains.setdefault(camera, PacketChain(unpack))
        self._heard[camera] = now
        if not chain.add(data):
            chain.clear()
            known = camera in self._asked
            self._asked.add(camera)
            return known
        self._asked.discard(camera)
        packets, before, end = chain.packets, len(chain.packets) - 1, chain.end
        frame = binary_frame(data)
        for viewer in viewers:
            cursors = viewer.video_cursors
            held, position = cursors.get(camera, START)
            if position < 0:
                if before and position == LATER.position and now >= cursors.joins_from:
                    del cursors[camera]
                    viewer.wake()
                if before:
                    continue
                cursors[camera] = START
            if viewer.ready() and (not before or (held is packets and position == before)):
                viewer.write(frame)
                cursors[camera] = end
            else:
                viewer.wake()
        return True

    def forget(self, camera: int) -> None:
        """Forget a camera's video that nobody here wants: the kept packets would soon have gaps."""
        self._chains.pop(camera, None)
        self._asked.discard(camera)

    def take_missing(self, viewer: Watcher, now: float) -> list[bytes]:
        """Return the packets that a viewer has to be given now, and move its cursors."""
        found: list[bytes] = []
        cursors = viewer.video_cursors
        for camera, chain in self._chains.items():
            if not viewer.films(camera):
                continue
            cursor = cursors.get(camera, START)
            begun = chain.position(cursor)
            if begun == len(chain.packets) or cursor.position < 0 or not self.flows(camera, now):
                continue
            missed = chain.packets[begun:]
            soon = chain.times[-1] - chain.times[begun] <= LATE_MS
            if camera not in cursors or soon or sum(map(len, missed)) <= len(chain.packets[0]):
                found += missed
                cursors[camera] = chain.end
            else:
                cursors[camera] = NEXT  # so that it is not woken for each packet
        return found

    def flows(self, camera: int, now: float) -> bool:
        """Return whether a newcomer can be given a camera's video at once."""
        chain = self._chains.get(camera)
        return chain is not None and bool(chain.packets) and now - self._heard[camera] < SILENT_S
