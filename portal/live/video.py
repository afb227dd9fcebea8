"""What each viewer is given of a camera's video: the same packets for all, never one without those that it changes.

A process keeps what came since the last key picture. A newcomer gets that at once; whoever falls behind is given what
is missing if that is short or no more bytes than a key picture, and nothing until the next key picture otherwise.
"""

from collections.abc import Iterable
from typing import Protocol

from portal.edge.direct import binary_frame
from robots.kit.contract.video import GROUP_S, Group, unpack

LATE_MS = 500  # what a viewer has missed may be so long, whatever its bytes
SILENT_S = GROUP_S + 0.5  # after which nothing that is kept belongs to what comes next
JOIN_S = 1.0  # between two times that a viewer is given all since the last key picture, at least
Given = tuple[list[bytes], int]  # of which group a viewer was given packets, and how many
NOTHING: Given = ([], 0)
NEXT: Given = ([], -1)  # it has to wait for the next key picture
LATER: Given = ([], -2)  # or until it may be given all since the last one again


class Watcher(Protocol):
    """A viewer as far as it matters here."""

    given: dict[int, Given]  # of each camera's video; a camera that is not in it has just been asked for
    joins_from: float  # when it may be given all since the last key picture (s)

    def films(self, camera: int) -> bool:
        """Return whether it wants video of a camera."""

    def ready(self) -> bool:
        """Return whether a frame may be written at once."""

    def write(self, frame: bytes) -> None:
        """Write a frame."""

    def wait(self) -> None:
        """Have it look soon for what it was not given yet, and be given nothing before that."""


class Videos:
    """The video of one robot's cameras since their last key pictures. `now` is monotonic (s)."""

    def __init__(self) -> None:
        self._groups: dict[int, Group] = {}
        self._heard: dict[int, float] = {}  # when the newest packet of each camera came
        self._asked: set[int] = set()  # cameras of which a key picture is needed

    def give(self, data: bytes, viewers: Iterable[Watcher], now: float) -> bool:
        """Give a new packet to those who want that camera's; False if a key picture has to be asked for.

        Raises ValueError.
        """
        camera = unpack(data).camera
        group = self._groups.setdefault(camera, Group())
        self._heard[camera] = now
        if not group.add(data):
            known = camera in self._asked
            self._asked.add(camera)
            return known
        self._asked.discard(camera)
        packets, before = group.packets, len(group.packets) - 1
        frame = binary_frame(data)
        for viewer in viewers:
            held, count = viewer.given.get(camera, NOTHING)
            if count < 0:
                if before and count == LATER[1] and now >= viewer.joins_from:
                    del viewer.given[camera]
                    viewer.wait()
                if before:
                    continue
                viewer.given[camera] = NOTHING
            if viewer.ready() and (not before or (held is packets and count == before)):
                viewer.write(frame)
                viewer.given[camera] = (packets, before + 1)
            else:
                viewer.wait()
        return True

    def forget(self, camera: int) -> None:
        """Nobody here wants that camera's video: what is kept would soon have gaps."""
        self._groups.pop(camera, None)
        self._asked.discard(camera)

    def missing(self, viewer: Watcher, now: float) -> list[bytes]:
        """Return what a viewer has to be given now, and note that it was."""
        found: list[bytes] = []
        for camera, group in self._groups.items():
            if not viewer.films(camera):
                continue
            held, count = viewer.given.get(camera, NOTHING)
            begun = count if held is group.packets else 0
            if begun == len(group.packets) or count < 0 or not self.flows(camera, now):
                continue
            missed = group.packets[begun:]
            soon = group.times[-1] - group.times[begun] <= LATE_MS
            if camera not in viewer.given or soon or sum(map(len, missed)) <= len(group.packets[0]):
                found += missed
                viewer.given[camera] = (group.packets, len(group.packets))
            else:
                viewer.given[camera] = NEXT  # so that it is not woken for each packet
        return found

    def flows(self, camera: int, now: float) -> bool:
        """Return whether a newcomer can be given a camera's video at once."""
        group = self._groups.get(camera)
        return group is not None and bool(group.packets) and now - self._heard[camera] < SILENT_S
