"""A camera's pictures as they come, as motion JPEG and one at a time."""

import asyncio
import contextlib

from portal.composites.parts import GONE_S, Parts, add, made
from portal.live.hub import hub
from portal.live.rooms import Viewer
from robots.clock import SYSTEM
from robots.messages import read_picture, taken_ms

NEXT_S = 5.0  # for a camera that nobody watched to send a picture
FRESH_S = 2.0


class Passed(Parts):
    """The pictures of one camera."""

    def __init__(self, slug: str, camera: int) -> None:
        super().__init__(slug, f"camera {camera}", frozenset({camera}))
        self._camera = camera

    async def make(self, viewer: Viewer) -> None:
        """Hand on each picture."""
        loop = asyncio.get_running_loop()
        heard = loop.time()
        while loop.time() - heard < GONE_S:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(1.0):
                    await viewer.wake.wait()
            viewer.wake.clear()
            viewer.events.clear()
            if viewer.state is not None:
                heard, viewer.state = loop.time(), None
            picture = viewer.frames.pop(self._camera, None)
            if picture is not None:
                self.tell(read_picture(picture))


def passed(slug: str, camera: int) -> Passed:
    """Return the pictures of a camera in the running event loop."""
    found = made(slug, f"camera {camera}")
    if not isinstance(found, Passed):
        found = Passed(slug, camera)
        add(found)
    return found


async def newest(slug: str, camera: int) -> tuple[int, bytes] | None:
    """Return the newest picture of a camera: when it was taken (ms since 1970) and the JPEG; None if there is none.

    A camera that nobody watched is given time to begin.
    """
    viewer = Viewer(slug)
    viewer.cameras = frozenset({camera})
    hub().attach(viewer)
    since_ms = (SYSTEM.now().timestamp() - FRESH_S) * 1000
    try:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(NEXT_S):
                while camera not in viewer.frames or taken_ms(viewer.frames[camera]) < since_ms:
                    await viewer.wake.wait()
                    viewer.wake.clear()
                    viewer.events.clear()
        packet = viewer.frames.get(camera)
        return (taken_ms(packet), read_picture(packet)) if packet is not None else None
    finally:
        hub().detach(viewer)
