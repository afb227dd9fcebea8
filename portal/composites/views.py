"""`/robots/<slug>/live/<name>.mjpg`: a drawn picture of all that a robot shows, as plain motion JPEG."""

from collections.abc import AsyncIterator
from functools import cache

from asgiref.sync import sync_to_async
from django.conf import settings
from django.db import connection
from django.http import HttpRequest, HttpResponse, HttpResponseBase, StreamingHttpResponse

from portal.composites.drawn import END, TYPE, drawn, watchers
from portal.limits.counts import AddressCount
from portal.live.audience import audience
from robots.clock import SYSTEM
from robots.contract.capabilities import Composite
from robots.contract.spec import Spec
from robots.grants import owner_alive
from robots.models import Lease, Robot

ABSENT = "There is no such picture.\n"
OFFLINE = "This robot is offline now; try again later.\n"
ENOUGH = "As many people watch this picture as the portal can serve; watch the robot's page instead.\n"
TOO_MANY = "Your network address watches as many of these pictures as it may; close one of them first.\n"


@cache
def _addresses() -> AddressCount:
    return AddressCount(settings.LIMITS["COMPOSITES"])


async def composite(request: HttpRequest, slug: str, name: str) -> HttpResponseBase:
    """Send the pictures until the reader goes or the robot's owner is gone."""
    if request.method not in ("GET", "HEAD"):
        return HttpResponse(status=405, headers={"Allow": "GET, HEAD"})
    spec, alive = await sync_to_async(_look)(slug)
    found = next((c for c in spec.all_of(Composite) if c.name == name), None) if spec is not None else None
    if spec is None or found is None:
        return _refused(404, ABSENT)
    if not alive:
        return _refused(503, OFFLINE)
    address = request.META.get("REMOTE_ADDR", "")
    if _addresses().open(address) >= settings.LIMITS["COMPOSITES"]:
        return _refused(429, TOO_MANY)
    if watchers(slug) >= settings.LIMITS["COMPOSITE_VIEWERS"]:
        return _refused(503, ENOUGH)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    if request.method == "HEAD":
        return HttpResponse(content_type=TYPE, headers=headers)
    return StreamingHttpResponse(_parts(slug, spec, found, address), content_type=TYPE, headers=headers)


def _look(slug: str) -> tuple[Spec | None, bool]:
    """Return the robot's spec and whether it has an owner; the thread's connection is not kept during the stream."""
    try:
        robot = Robot.objects.filter(slug=slug).first()
        if robot is None:
            return None, False
        return robot.spec(), owner_alive(Lease.objects.filter(robot=robot).first(), SYSTEM.now())
    except LookupError:
        return None, False
    finally:
        if not connection.in_atomic_block:
            connection.close()


async def _parts(slug: str, spec: Spec, found: Composite, address: str) -> AsyncIterator[bytes]:
    """Count the reader from the first part to the last, whatever ends it."""
    with _addresses().one(address) as room:
        if room and watchers(slug) < settings.LIMITS["COMPOSITE_VIEWERS"]:
            shown = drawn(slug, spec, found)
            with shown.watched(), audience().one(slug) as seat:
                async for part in shown.parts():
                    seat.sent_bytes += len(part)
                    yield part
    yield END


def _refused(status: int, text: str) -> HttpResponse:
    more = {"Retry-After": "30"} if status in (429, 503) else {}
    return HttpResponse(text, status=status, content_type="text/plain; charset=utf-8", headers=more)
