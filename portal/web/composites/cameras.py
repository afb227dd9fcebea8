"""A camera's pictures as they come, as motion JPEG and one at a time."""

import asyncio

from portal.live.loop import of_loop
from portal.live.viewer import Viewer, Wish
from portal.web.composites.parts import GONE_S, Parts, shared
from robots.kit.clock import SYSTEM
from robots.kit.packets import read_picture, taken_ms

NEXT_S = 5.0  # for a camera that nobody watched to send a picture
FRESH_S, SAME_S = 2.0, 1.0
Taken = tuple[int, bytes] | None


def _fresh(kept: bytes | None) -> bytes | None:
    """Return the picture that a viewer was given when it came, if it is fresh. What comes later is fresh.

    So a picture is shown also if the clocks of the robot's host and of this one differ.
    """
    age_s = SYSTEM.now().timestamp() - taken_ms(kept) / 1000 if kept is not None else 0.0
    return kept if abs(age_s) < FRESH_S else None


class Passed(Parts):
    """The pictures of one camera."""

    def __init__(self, slug: str, camera: int) -> None:
        super().__init__(slug, f"camera {camera}", frozenset({camera}))
        self._camera = camera

    async def make(self, viewer: Viewer) -> None:
        """Hand on each picture; end when none comes any more, for a frozen stream must not look live."""
        loop = asyncio.get_running_loop()
        seen, picture = loop.time(), _fresh(viewer.take_picture(self._camera))
        while loop.time() - seen < GONE_S:
            if picture is not None:
                seen = loop.time()
                self.tell(read_picture(picture))
            await viewer.wait_for_mail(1.0)
            viewer.drop_events()
            picture = viewer.take_picture(self._camera)


def passed(slug: str, camera: int) -> Parts:
    """Return the pictures of a camera in the running event loop."""
    return shared(slug, f"camera {camera}", lambda: Passed(slug, camera))


_newest: dict[tuple[int, str, int], asyncio.Task[Taken]] = {}


async def newest(slug: str, camera: int) -> Taken:
    """Return the newest picture of a camera: when it was taken (ms since 1970) and the JPEG; None if there is none.

    A camera that nobody watched is given time to begin. Everybody who asks within a second gets the same picture.
    """
    loop = asyncio.get_running_loop()
    key = (id(loop), slug, camera)
    asked = _newest.get(key)
    if asked is None:
        asked = _newest[key] = loop.create_task(_look(slug, camera))
        asked.add_done_callback(lambda _: loop.call_later(SAME_S, _newest.pop, key, None))
    return await asyncio.shield(asked)


async def _look(slug: str, camera: int) -> Taken:
    viewer = Viewer(slug, wish=Wish(frozenset({camera})))
    of_loop().hub.attach(viewer)
    packet = _fresh(viewer.take_picture(camera))
    try:
        async with asyncio.timeout(NEXT_S):
            while packet is None:
                await viewer.wait_for_mail(NEXT_S)
                viewer.drop_events()
                packet = viewer.take_picture(camera)
        return taken_ms(packet), read_picture(packet)
    except TimeoutError:
        return None
    finally:
        of_loop().hub.detach(viewer)
