"""Live pictures for other software: motion JPEG of a drawing or a camera, and a camera's newest picture.

`/robots/<slug>/live/<name>.mjpg`, `/robots/<slug>/camera/<number>.mjpg`, `/robots/<slug>/camera/<number>.jpg`.
"""

from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

from asgiref.sync import sync_to_async
from django.conf import settings
from django.contrib.auth.models import AnonymousUser
from django.db import Error, connection
from django.http import HttpRequest, HttpResponse, HttpResponseBase, HttpResponseRedirect, StreamingHttpResponse
from django.urls import reverse
from django.utils.cache import get_conditional_response
from django.utils.http import http_date
from django.utils.translation import gettext_lazy
from django.views.decorators.http import require_safe

from portal.edge.cache_control import FOR_GOOD
from portal.edge.limits import AddressCount
from portal.edge.pages import leave_room
from portal.live.loop import of_loop
from portal.live.messages import CAMERAS
from portal.live.snapshot import visible_frame
from portal.live.threads import Pool
from portal.web.composites.cameras import newest, shared_camera
from portal.web.composites.drawing import shared_drawing
from portal.web.composites.parts import GONE_S, TYPE, Parts, multipart, watchers
from robots import bus
from robots.grants import lease_of, owner_alive
from robots.kit import description
from robots.kit.clock import SYSTEM
from robots.kit.contract.capabilities import Composite
from robots.kit.contract.spec import Spec
from robots.models import Robot
from robots.services import newest_still

if TYPE_CHECKING:
    from django.utils.functional import _StrPromise

ABSENT = gettext_lazy("There is no such picture.")
Still = Callable[[], Awaitable[bytes]] | None  # reads the first picture of a stream
PICTURES = Pool("pictures", 2)
LATEST_S = 2**37  # no picture is taken later (s since 1970)
NOT_KEPT = gettext_lazy("That picture is no longer kept; ask for the newest one.")
NO_PICTURE = gettext_lazy("The camera sends no picture now; try again later.")
OFFLINE = gettext_lazy("This robot is offline now; try again later.")
ENOUGH = gettext_lazy("As many people watch this picture as the portal can serve; watch the robot's page instead.")
TOO_MANY = gettext_lazy("Your network address watches as many of these pictures as it may; close one of them first.")


@cache
def _addresses() -> AddressCount:
    return AddressCount(settings.LIMITS["COMPOSITES"])


@require_safe
async def composite(request: HttpRequest, slug: str, name: str) -> HttpResponseBase:
    """Send a drawn picture of all that the robot shows until the reader goes or the robot's owner is gone."""
    robot = await sync_to_async(_look)(slug)
    found = next((c for c in robot.spec.all_of(Composite) if c.name == name), None) if robot is not None else None
    if robot is None or found is None:
        return _refused(404, ABSENT)
    return _stream(request, robot, lambda: shared_drawing(slug, robot.spec, found))


@require_safe
async def camera(request: HttpRequest, slug: str, number: int) -> HttpResponseBase:
    """Send a camera's pictures until the reader goes or the robot's owner is gone."""
    robot = await sync_to_async(_look)(slug)
    if robot is None or number >= robot.cameras:
        return _refused(404, ABSENT)
    still = partial(PICTURES.run, _newest_still, slug) if number == 0 else None
    return _stream(request, robot, lambda: shared_camera(slug, number), still)


@require_safe
async def snapshot(request: HttpRequest, slug: str, number: int) -> HttpResponseBase:
    """Redirect to the address of a camera's newest picture, which is new for each picture and can be cached."""
    robot = await sync_to_async(_look)(slug)
    if robot is None or number >= robot.cameras:
        return _refused(404, ABSENT)
    if not robot.alive:
        return _refused(503, OFFLINE)
    with _addresses().one(request.META.get("REMOTE_ADDR", "")) as room:
        if not room:
            return _refused(429, TOO_MANY)
        leave_room(request)
        found = await newest(slug, number)
    if found is None:
        return _refused(503, NO_PICTURE)
    at_ms, jpeg = found
    if not await PICTURES.run(bus.keep_shot, slug, number, at_ms, jpeg):
        return HttpResponse(jpeg, content_type="image/jpeg", headers={"Cache-Control": "no-store"})
    to = reverse("shot", args=[slug, number, at_ms])
    return HttpResponseRedirect(to, headers={"Cache-Control": "public, max-age=1"})


@require_safe
async def shot(request: HttpRequest, slug: str, number: int, at_ms: int) -> HttpResponseBase:
    """Send one picture; its address is never used for another one."""
    seconds, jpeg = at_ms // 1000, None
    if number < CAMERAS and seconds < LATEST_S:
        jpeg = await PICTURES.run(bus.shot, slug, number, at_ms)
    if jpeg is None:
        return _refused(404, NOT_KEPT)
    etag = f'"{slug}-{number}-{at_ms}"'
    answer = HttpResponse(jpeg, content_type="image/jpeg")
    answer = get_conditional_response(request, etag=etag, last_modified=seconds, response=answer) or answer
    answer.headers["Cache-Control"] = FOR_GOOD
    answer.headers["ETag"], answer.headers["Last-Modified"] = etag, http_date(seconds)
    return answer


@dataclass(frozen=True)
class LiveRobot:
    """The facts about a robot that its live pictures need."""

    slug: str
    spec: Spec
    cameras: int
    alive: bool


@contextmanager
def _brief_connection() -> Iterator[None]:
    """Close the thread's connection to the database at the end, because a stream may last for hours."""
    try:
        yield
    finally:
        if not connection.in_atomic_block:
            connection.close()


@_brief_connection()
def _look(slug: str) -> LiveRobot | None:
    """Return what is known of a robot; None if it or its package is not there."""
    try:
        robot = Robot.objects.filter(slug=slug).first()
        if robot is None:
            return None
        alive = owner_alive(lease_of(robot), SYSTEM.now())
        return LiveRobot(slug, robot.spec(), len(description.views(robot.description())), alive)
    except LookupError:
        return None


@_brief_connection()
def _newest_still(slug: str) -> bytes:
    """Return the robot's newest kept picture, which its first camera took; empty if there is none for everybody.

    A live stream begins with it, so a picture that is older than `GONE_S` is left out.
    """
    try:
        frame = visible_frame(newest_still(Robot.objects.get(slug=slug)), AnonymousUser())
        if frame is None or abs((SYSTEM.now() - frame.taken_at).total_seconds()) > GONE_S:
            return b""
        return (Path(settings.MEDIA_ROOT) / frame.file).read_bytes()
    except (OSError, Error, Robot.DoesNotExist):
        return b""


def _stream(request: HttpRequest, robot: LiveRobot, make: Callable[[], Parts], still: Still = None) -> HttpResponseBase:
    """Return the stream of a moving picture, or why there is none now."""
    if not robot.alive:
        return _refused(503, OFFLINE)
    address = request.META.get("REMOTE_ADDR", "")
    if _addresses().open(address) >= settings.LIMITS["COMPOSITES"]:
        return _refused(429, TOO_MANY)
    if watchers(robot.slug) >= settings.LIMITS["COMPOSITE_VIEWERS"]:
        return _refused(503, ENOUGH)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    if request.method == "HEAD":
        return HttpResponse(content_type=TYPE, headers=headers)
    return StreamingHttpResponse(_parts(robot.slug, make, address, still), content_type=TYPE, headers=headers)


async def _parts(slug: str, make: Callable[[], Parts], address: str, still: Still) -> AsyncIterator[bytes]:
    """Count the reader from the first part to the last, however it ends."""
    with _addresses().one(address) as room:
        if room and watchers(slug) < settings.LIMITS["COMPOSITE_VIEWERS"]:
            shown = make()
            with shown.watched(), of_loop().audience.one(slug) as seat:
                first = await still() if still is not None else b""
                async for part in multipart(shown.parts(first)):
                    seat.sent_bytes += len(part)
                    yield part


def _refused(status: int, text: "_StrPromise") -> HttpResponse:
    more = {"Retry-After": "30"} if status in (429, 503) else {}
    return HttpResponse(f"{text}\n", status=status, content_type="text/plain; charset=utf-8", headers=more)
