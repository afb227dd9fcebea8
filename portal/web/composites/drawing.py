"""A composite of one robot: drawn ten times a second while somebody watches, once for all who watch."""

import asyncio
import logging
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from django.db import Error

from portal.live.loop import of_loop
from portal.live.threads import ANYBODY, Pool
from portal.live.viewer import Viewer
from portal.web.composites.parts import GONE_S, Parts, shared
from queueing.services import in_order
from robots.kit.contract.capabilities import Composite
from robots.kit.contract.find import function
from robots.kit.contract.session import RobotState
from robots.kit.contract.spec import Spec
from robots.kit.contract.streams import unpack
from robots.kit.packets import read_picture, read_state
from robots.models import Robot

if TYPE_CHECKING:  # arrays, which a portal whose pictures nobody watches need not load
    from robots.kit.contract.composites import Pixels, Scene

log = logging.getLogger(__name__)
EVERY_S = 0.1
UNHEARD_S = 1.0  # between two pictures while nothing new comes from the robot
JOBS_S = 1.0  # between two queries for the jobs that wait
MOST_JOBS = 10
QUALITY = 40  # with a Huffman table for each picture; robots/kit/drivers/irat/README.md has bytes and likeness
THREAD = Pool("composites", 1)


class Drawing(Parts):
    """One composite of one robot in one event loop; it runs from its first watcher to its last."""

    def __init__(self, slug: str, spec: Spec, composite: Composite) -> None:
        super().__init__(slug, composite.name, frozenset({0}))
        self._spec, self._composite = spec, composite
        self._scene: Scene | None = None
        self._picture: bytes | None = None
        self._state: RobotState | None = None
        self._jobs: list[dict[str, Any]] = []
        self._looked = -JOBS_S
        self._broken: set[int] = set()  # streams of which a packet could not be read, until their next key packet

    async def make(self, viewer: Viewer) -> None:
        """Draw the robot's packets, picture and state ten times a second."""
        clock = asyncio.get_running_loop().time
        heard = seen = due = clock()
        shown = -UNHEARD_S
        while clock() - heard < GONE_S:
            due = max(due + EVERY_S, clock())
            await asyncio.sleep(due - clock())
            packets = of_loop().hub.news(viewer)
            news, picture = viewer.take_state(), viewer.take_picture(0)
            viewer.drop_events()
            if news is not None:
                heard = clock()
            seen = clock() if picture is not None else seen
            if clock() - seen > GONE_S:
                self._picture = None  # an old one must not look live
            if clock() - self._looked >= JOBS_S:
                self._looked = clock()
                with suppress(Error):  # while the database is away the jobs that were known are drawn
                    self._jobs = await ANYBODY.orm(waiting_jobs)(self.slug)
            if packets or picture or news is not None or clock() - shown >= UNHEARD_S:
                jpeg = await THREAD.run(self._drawn, packets, picture, news)
                shown = clock()
                self.tell(jpeg)

    def _drawn(self, packets: list[bytes], picture: bytes | None, state: bytes | None) -> bytes:
        """Return the next JPEG; runs in the one thread for composites."""
        if self._scene is None:
            self._scene = function(self._composite.scene)(self._composite.width, self._composite.height)
        for data in packets:
            self._take(self._scene, data)
        try:
            self._picture = read_picture(picture) if picture is not None else self._picture
            self._state = read_state(state, self._spec.packed()) if state is not None else self._state
        except ValueError as error:
            log.warning("the composite of %s: %s", self.slug, error)
        pixels = self._scene.draw(self._picture, self._state, self._jobs)
        return compressed(pixels)

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
            log.warning("the composite of %s: %s", self.slug, error)


def compressed(pixels: "Pixels") -> bytes:
    """Return a drawing as JPEG."""
    import cv2  # noqa: PLC0415 - 40 MB that only a composite needs

    return bytes(cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, QUALITY, cv2.IMWRITE_JPEG_OPTIMIZE, 1])[1])


def shared_drawing(slug: str, spec: Spec, composite: Composite) -> Parts:
    """Return the composite of the running event loop; one that nobody watches yet draws nothing."""
    return shared(slug, composite.name, lambda: Drawing(slug, spec, composite))


def waiting_jobs(slug: str) -> list[dict[str, Any]]:
    """Return the arguments of the robot's open jobs, in the order in which its page numbers them."""
    robot = Robot.objects.filter(slug=slug).first()
    found = in_order(robot)[:MOST_JOBS] if robot is not None else []
    return [job.args for job in found if isinstance(job.args, dict)]
