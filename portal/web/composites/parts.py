"""Pictures as motion JPEG: made from the first watcher to the last, once for all; slow readers skip some."""

import asyncio
import logging
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager

from portal.live.loop import of_loop, once_per_loop
from portal.live.viewer import Viewer, Wish

log = logging.getLogger(__name__)
GONE_S = 5.0  # without a state: the robot's owner is gone; without a picture: its camera is
BOUNDARY = b"farhand"
TYPE = f"multipart/x-mixed-replace; boundary={BOUNDARY.decode()}"
# A browser shows a part when it has read the head of the next: so that comes with the part, and one with the first. The
# last head is followed by the last picture once more: an empty part is damage to players of films.
HEAD = b"--" + BOUNDARY + b"\r\nContent-Type: image/jpeg\r\n\r\n"
END = b"\r\n--" + BOUNDARY + b"--"  # FFmpeg takes a line that ends here for the head of one more part


def part_of(jpeg: bytes) -> bytes:
    """Return a picture as one part of an answer that has begun with `HEAD`."""
    return jpeg + b"\r\n" + HEAD


async def multipart(parts: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
    """Yield the whole answer of which these are the parts, from its first head to its end; nothing without a part."""
    last = b""
    async for part in parts:
        yield part if last else HEAD + part
        last = part
    if last:
        yield last.removesuffix(b"\r\n" + HEAD) + END


class Parts(ABC):
    """One moving picture of one robot in one event loop; subclasses `make` it."""

    def __init__(self, slug: str, name: str, cameras: frozenset[int]) -> None:
        self.slug, self.name, self._cameras = slug, name, cameras
        self._made = _made()
        self.watchers, self.over = 0, False
        self.frames = 0  # how many were made
        self._part, self._next = b"", asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    @abstractmethod
    async def make(self, viewer: Viewer) -> None:
        """Make pictures from the viewer's mailbox, `tell` each; return when nothing comes any more."""

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Have the pictures made during the body of a `with` statement."""
        self.watchers += 1
        task = self._task = self._task or asyncio.create_task(self._run())
        try:
            yield
        finally:
            self.watchers -= 1
            if not self.watchers:
                self._end()
                task.cancel()

    async def parts(self, still: bytes = b"") -> AsyncIterator[bytes]:
        """Yield the newest picture as a part of the answer, again and again; slow readers skip some.

        The first part comes at once; it is `still`, a JPEG, if no picture was made yet. The parts end when the robot's
        owner or its camera is gone.
        """
        if self._part or still:
            yield self._part or part_of(still)
        while not self.over:
            await self._next.wait()
            if not self.over:
                yield self._part

    def tell(self, jpeg: bytes) -> None:
        """Give all watchers the next picture."""
        self.frames += 1
        self._part = part_of(jpeg)
        told, self._next = self._next, asyncio.Event()
        told.set()

    async def _run(self) -> None:
        viewer = Viewer(self.slug, wish=Wish(self._cameras))
        of_loop().hub.attach(viewer)
        try:
            await self.make(viewer)
        except Exception:
            log.exception("the moving picture %s of %s failed", self.name, self.slug)
        finally:
            of_loop().hub.detach(viewer)
            self._end()

    def _end(self) -> None:
        """Take no more watchers; wake those that wait."""
        self.over = True
        if self._made.get((self.slug, self.name)) is self:
            del self._made[self.slug, self.name]
        self._next.set()


_made = once_per_loop(dict[tuple[str, str], Parts])  # the moving pictures that are watched, by robot and name


def shared(slug: str, name: str, make: Callable[[], Parts]) -> Parts:
    """Return the moving picture of that name in the running event loop; made now if nobody watches it yet."""
    made = _made()
    if (slug, name) not in made:
        made[slug, name] = make()
    return made[slug, name]


def watchers(slug: str) -> int:
    """Return how many watch moving pictures of that robot in the running event loop."""
    return sum(one.watchers for (robot, _), one in _made().items() if robot == slug)
