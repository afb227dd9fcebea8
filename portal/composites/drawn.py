"""A composite of one robot: drawn ten times a second while somebody watches, once for all who watch."""

import asyncio
import logging
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from django.db import Error

from portal.live.hub import hub
from portal.live.rooms import Viewer
from portal.live.threads import ANYBODY, Pool
from queueing.jobs.foreseeing import in_order
from robots.contract.capabilities import Composite
from robots.contract.find import function
from robots.contract.session import RobotState
from robots.contract.spec import Spec
from robots.contract.streams import unpack
from robots.messages import read_picture, read_state
from robots.models import Robot

if TYPE_CHECKING:  # arrays, which a portal whose pictures nobody watches need not load
    from robots.contract.composites import Scene

log = logging.getLogger(__name__)
EVERY_S = 0.1
UNHEARD_S = 1.0  # between two pictures of a robot that tells nothing new
GONE_S = 5.0  # without a state: its owner is gone
JOBS_S = 1.0  # between two looks at the jobs that wait
MOST_JOBS = 10
QUALITY = 70
BOUNDARY = b"farhand"
TYPE = f"multipart/x-mixed-replace; boundary={BOUNDARY.decode()}"
END = b"--" + BOUNDARY + b"--\r\n"
THREAD = Pool("composites", 1)


class Drawn:
    """One composite of one robot in one event loop; it runs from its first watcher to its last."""

    def __init__(self, slug: str, spec: Spec, composite: Composite) -> None:
        self._slug, self._spec, self._composite = slug, spec, composite
        self._key = (id(asyncio.get_running_loop()), slug, composite.name)
        self.watchers, self.over = 0, False
        self.frames = 0  # how many were drawn
        self._part, self._next = b"", asyncio.Event()
        self._scene: Scene | None = None
        self._picture: bytes | None = None
        self._state: RobotState | None = None
        self._jobs: list[dict[str, Any]] = []
        self._looked = -JOBS_S
        self._broken: set[int] = set()  # streams of which a packet could not be read, until their next key packet
        self._task: asyncio.Task[None] | None = None

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Have it drawn during the body of a `with` statement."""
        self.watchers += 1
        task = self._task = self._task or asyncio.create_task(self._run())
        try:
            yield
        finally:
            self.watchers -= 1
            if not self.watchers:
                self._end()
                task.cancel()

    def _end(self) -> None:
        """Take no more watchers; those that wait are told."""
        self.over = True
        if _drawn.get(self._key) is self:
            del _drawn[self._key]
        self._next.set()

    async def parts(self) -> AsyncIterator[bytes]:
        """Yield the newest picture as a part of the answer, again and again; who reads slowly skips some.

        Ends when the robot's owner is gone.
        """
        if self._part:
            yield self._part
        while not self.over:
            await self._next.wait()
            if not self.over:
                yield self._part

    async def _run(self) -> None:
        viewer = Viewer(self._slug)
        hub().attach(viewer)
        try:
            await self._draw_all(viewer)
        except Exception:
            log.exception("the composite %s of %s failed", self._composite.name, self._slug)
        finally:
            hub().detach(viewer)
            self._end()

    async def _draw_all(self, viewer: Viewer) -> None:
        heard = due = time.monotonic()
        shown = -UNHEARD_S
        while time.monotonic() - heard < GONE_S:
            due = max(due + EVERY_S, time.monotonic())
            await asyncio.sleep(due - time.monotonic())
            packets = hub().streams.news(self._slug, viewer.told)
            news, picture = (viewer.state, viewer.frames.pop(0, None))
            viewer.state = None
            viewer.events.clear()
            if news is not None:
                heard = time.monotonic()
            if time.monotonic() - self._looked >= JOBS_S:
                self._looked = time.monotonic()
                with suppress(Error):  # while the database is away the jobs that were known are drawn
                    self._jobs = await ANYBODY.orm(waiting_jobs)(self._slug)
            if packets or picture or news is not None or time.monotonic() - shown >= UNHEARD_S:
                jpeg = await THREAD.run(self._drawn, packets, picture, news)
                shown = time.monotonic()
                self._tell(jpeg)

    def _tell(self, jpeg: bytes) -> None:
        self.frames += 1
        head = b"--%s\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % (BOUNDARY, len(jpeg))
        self._part = head + jpeg + b"\r\n"
        told, self._next = self._next, asyncio.Event()
        told.set()

    def _drawn(self, packets: list[bytes], picture: bytes | None, state: bytes | None) -> bytes:
        """Return the next JPEG; runs in the one thread for composites."""
        import cv2  # noqa: PLC0415 - 40 MB that only a composite needs

        if self._scene is None:
            self._scene = function(self._composite.scene)(self._composite.width, self._composite.height)
        for data in packets:
            self._take(self._scene, data)
        try:
            self._picture = read_picture(picture) if picture is not None else self._picture
            self._state = read_state(state, self._spec.packed()) if state is not None else self._state
        except ValueError as error:
            log.warning("the composite of %s: %s", self._slug, error)
        pixels = self._scene.draw(self._picture, self._state, self._jobs)
        return bytes(cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1])

    def _take(self, scene: "Scene", data: bytes) -> None:
        """Give the scene a packet; after one that cannot be read it waits for that stream's next key packet."""
        packet = unpack(data)
        if packet.stream >= len(self._spec.streams) or (packet.stream in self._broken and not packet.key):
            return
        self._broken.discard(packet.stream)
        try:
            scene.take(self._spec.streams[packet.stream].name, packet.data, packet.key)
        except ValueError as error:
            self._broken.add(packet.stream)
            log.warning("the composite of %s: %s", self._slug, error)


_drawn: dict[tuple[int, str, str], Drawn] = {}


def drawn(slug: str, spec: Spec, composite: Composite) -> Drawn:
    """Return the composite of the running event loop; one that nobody watches yet draws nothing."""
    key = (id(asyncio.get_running_loop()), slug, composite.name)
    found = _drawn.get(key)
    if found is None:
        found = _drawn[key] = Drawn(slug, spec, composite)
    return found


def watchers(slug: str) -> int:
    """Return how many watch composites of that robot in the running event loop."""
    loop = id(asyncio.get_running_loop())
    return sum(one.watchers for (of, name, _), one in _drawn.items() if (of, name) == (loop, slug))


def waiting_jobs(slug: str) -> list[dict[str, Any]]:
    """Return the arguments of the robot's open jobs, in the order in which its page numbers them."""
    robot = Robot.objects.filter(slug=slug).first()
    found = in_order(robot)[:MOST_JOBS] if robot is not None else []
    return [job.args for job in found if isinstance(job.args, dict)]
