"""A camera's pictures as they come, as motion JPEG and one at a time."""

import asyncio

from portal.live.loop import of_loop, once_per_loop
from portal.live.viewer import Viewer, Wish
from portal.web.composites.parts import GONE_S, Parts, shared
from robots.kit.clock import SYSTEM
from robots.kit.packets import read_picture, taken_ms

NEXT_S = 5.0  # for a camera that nobody watched to send a picture
FRESH_S, SAME_S = 2.0, 1.0  # a picture is fresh for so long, and answers everybody for so long
Taken = tuple[int, bytes] | None


def _fresh(packet: bytes | None) -> bytes | None:
    """Return the picture that a new viewer was given, if it is fresh.

    Later pictures count as fresh, so they are shown though the clocks of the robot's host and of this one differ.
    """
    age_s = SYSTEM.now().timestamp() - taken_ms(packet) / 1000 if packet is not None else 0.0
    return packet if abs(age_s) < FRESH_S else None


class CameraParts(Parts):
    """The pictures of one camera, unchanged."""

    def __init__(self, slug: str, camera: int) -> None:
        super().__init__(slug, f"camera {camera}", frozenset({camera}))
        self._camera = camera

    async def make(self, viewer: Viewer) -> None:
        """Show each picture; end when none comes any more, because a frozen stream must not look live."""
        loop = asyncio.get_running_loop()
        seen, picture = loop.time(), _fresh(viewer.take_picture(self._camera))
        while loop.time() - seen < GONE_S:
            if picture is not None:
                seen = loop.time()
                self.tell(read_picture(picture))
            await viewer.wait_for_mail(1.0)
            viewer.drop_events()
            picture = viewer.take_picture(self._camera)


def shared_camera(slug: str, camera: int) -> Parts:
    """Return the pictures of a camera in the running event loop."""
    return shared(slug, f"camera {camera}", lambda: CameraParts(slug, camera))


_looks = once_per_loop(dict[tuple[str, int], asyncio.Task[Taken]])  # the tasks that look for a camera's newest picture


async def newest(slug: str, camera: int) -> Taken:
    """Return the newest picture of a camera: when it was taken (ms since 1970) and the JPEG; None if there is none.

    A camera that nobody watched is given time to begin. Everybody who asks within a second gets the same picture.
    """
    looks, key, loop = _looks(), (slug, camera), asyncio.get_running_loop()
    if key not in looks:
        looks[key] = loop.create_task(_look(slug, camera))
        looks[key].add_done_callback(lambda _: loop.call_later(SAME_S, looks.pop, key, None))
    return await asyncio.shield(looks[key])


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
