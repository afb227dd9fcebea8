"""Pages of recordings: the replay, its index and its slices, and the file."""

import threading
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import msgspec
from django.core.cache import cache
from django.http import Http404, HttpRequest, HttpResponse, HttpResponseBase
from django.shortcuts import render
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_safe

from portal.web.consoles.console import console_of
from portal.web.pages.errors import software_missing
from portal.web.pages.serving import limited, ranged
from portal.web.pages.views import console_facts
from portal.web.recordings import access
from portal.web.recordings.exports import arriving, movies_of
from robots.kit import description
from robots.models import Recording, Robot
from robots.recordings import keeping

if TYPE_CHECKING:
    from robots.kit.recording.timeline import Index

MCAP = "application/octet-stream"
FOR_GOOD = "private, max-age=86400, immutable"  # a slice's address names the version of its recording
BUSY = "Other recordings are being read; try again in some seconds.\n"
INDEX = "recording-index-2"  # kept indexes; the number changes with their content
COLD, COLD_S = threading.BoundedSemaphore(), 10.0  # a whole file is read for an index: one at a time in a process


@never_cache
@require_safe
def replay(request: HttpRequest, key: str) -> HttpResponse:
    """Show a recording: the robot's console without controls, and a bar to move in time."""
    recording, about = access.visible(key, request.user, shown=False)
    robot = recording.robot
    movies = movies_of(recording)
    context: dict[str, Any] = {
        "recording": recording, "about": about, "robot": robot, "words": access.words_for(recording),
        "view": recording.replayable, "movies": movies, "arriving": arriving(movies), "replaying": True,
    }  # fmt: skip
    if recording.replayable:
        try:
            described, console = robot.description(), console_of(robot.driver)
            context |= {"description_json": console_facts(robot, None), "views": description.views(described)}
        except (LookupError, ImportError, OSError):
            return software_missing(request, robot.name)
        context |= {**asdict(console), "replay_json": _facts(recording, about)}
    answer = render(request, "recordings/replay.html", context)
    if about is None or about.quiet or about.hidden:
        answer["X-Robots-Tag"] = "noindex, nofollow"
    return answer


def _facts(recording: Recording, about: access.About | None) -> dict[str, Any]:
    return {
        "index": f"{recording.get_absolute_url()}{recording.version}/index.json",
        "slices": f"{recording.get_absolute_url()}{recording.version}/",
        "slug": recording.robot.slug, "name": recording.robot.full_name, "who": about.who if about else "",
    }  # fmt: skip


def _readable(request: HttpRequest, key: str, version: int) -> Recording:
    recording, _ = access.visible(key, request.user)
    if version != recording.version:
        raise Http404("The recording was changed; reload its page.")
    return recording


def _index(recording: Recording) -> "Index | None":
    """Return the index of a recording, kept for a while; None if too many are read now. Raises Http404."""
    name = f"{INDEX}:{recording.pk}:{recording.version}"
    kept = cache.get(name)
    if kept is None:
        if not COLD.acquire(timeout=COLD_S):
            return None
        try:
            kept = cache.get(name) or _read(recording)  # somebody may have read it meanwhile
        finally:
            COLD.release()
        cache.set(name, kept, 600)
    from robots.kit.recording.timeline import Index  # noqa: PLC0415 - the reader is loaded when it is needed

    return msgspec.json.decode(kept, type=Index)


def _read(recording: Recording) -> str:
    from robots.kit.recording.timeline import read_index  # noqa: PLC0415 - see _index

    try:
        return msgspec.json.encode(read_index(keeping.path_of(recording))).decode()
    except OSError as error:
        raise Http404("The recording's file is gone.") from error


def _busy() -> HttpResponse:
    return HttpResponse(BUSY, status=503, content_type="text/plain", headers={"Retry-After": "5"})


@require_safe
def index(request: HttpRequest, key: str, version: int) -> HttpResponse:
    """Return what happened when, as JSON."""
    refused = limited(request)
    if refused is not None:
        return refused
    found = _index(_readable(request, key, version))
    if found is None:
        return _busy()
    told = msgspec.to_builtins(found)
    del told["places"], told["topics"]  # they are for `part`
    answer = HttpResponse(msgspec.json.encode(told), content_type="application/json")
    answer["Cache-Control"] = FOR_GOOD
    return answer


@require_safe
def part(request: HttpRequest, key: str, version: int, number: int) -> HttpResponse:
    """Return a slice: the packets of five seconds."""
    from robots.kit.recording.timeline import read_slice  # noqa: PLC0415 - see _index

    refused = limited(request, "slices")
    if refused is not None:
        return refused
    recording = _readable(request, key, version)
    known = _index(recording)
    if known is None:
        return _busy()
    if number >= len(known.needs):
        raise Http404("The recording is shorter.")
    joints, channels = _names(recording.robot)
    try:
        data = read_slice(keeping.path_of(recording), known, number, joints, channels)
    except OSError as error:
        raise Http404("The recording cannot be read.") from error
    whole = len(known.places) == len(known.needs)  # else there may be more in the slice than was found
    return HttpResponse(data, content_type=MCAP, headers={"Cache-Control": FOR_GOOD if whole else "no-store"})


def _names(robot: Robot) -> tuple[tuple[str, ...], list[str]]:
    try:
        spec = robot.spec()
    except LookupError as error:
        raise Http404("The robot's software is not installed.") from error
    return spec.joints, [channel.name for channel in spec.packed()]


@never_cache
@require_safe
def download(request: HttpRequest, key: str) -> HttpResponseBase:
    """Return the recording's file, for programs that read MCAP."""
    refused = limited(request)
    if refused is not None:
        return refused
    recording, _ = access.visible(key, request.user)
    name = f"{recording.robot.slug}-{recording.began_at:%Y%m%d-%H%M%S}.mcap"
    return ranged(request, keeping.path_of(recording), MCAP, name)
