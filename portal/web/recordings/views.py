"""Pages of recordings: the list of a robot's newest, the replay, its index and its slices, and the file."""

import threading
from dataclasses import dataclass
from datetime import timedelta
from typing import TYPE_CHECKING, Any

import msgspec
from django.conf import settings
from django.core.cache import cache
from django.http import Http404, HttpRequest, HttpResponse, HttpResponseBase
from django.shortcuts import get_object_or_404, render
from django.utils.translation import gettext
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_safe

from portal.web.pages.errors import software_missing
from portal.web.pages.serving import file_response, limit_rate
from portal.web.pages.views import console_context
from portal.web.recordings import access
from portal.web.recordings.exports import movies_of
from portal.web.recordings.moments import LONGEST, card_tags, moment_in
from queueing.models import JobRun
from queueing.services import offers_turns
from robots.kit.clock import SYSTEM
from robots.models import Movie, Recording, Robot
from robots.models.recordings import SHOWN
from robots.recordings import keeping

if TYPE_CHECKING:
    from robots.kit.recording.timeline import Index

LISTED, LOOKED = 20, 60
MCAP = "application/octet-stream"
FOR_GOOD = "private, max-age=86400, immutable"  # a slice's address names the version of its recording
BUSY = "Other recordings are being read; try again in some seconds.\n"
INDEX = "recording-index-2"  # the cache key of indexes; the number changes with their content
COLD, COLD_S = threading.BoundedSemaphore(), 10.0  # an index needs a whole file: one is read at a time in a process


@dataclass(frozen=True)
class Listed:
    """A recording of the list, with the turn or job that it shows."""

    recording: Recording
    about: access.About

    @property
    def length(self) -> str:
        """Return its length as minutes and seconds."""
        ended = self.recording.ended_at or self.recording.began_at
        passed = ended - self.recording.began_at
        if not timedelta() <= passed < LONGEST:
            return gettext("not known: the time of day was set")
        minutes, seconds = divmod(int(passed.total_seconds()), 60)
        return f"{minutes}:{seconds:02}"


@never_cache
@require_safe
@limit_rate()
def recordings_of(request: HttpRequest, slug: str) -> HttpResponse:
    """List the recordings that everybody may see, without jobs of guests, who alone know their addresses."""
    robot = get_object_or_404(Robot, slug=slug)
    found: list[Listed] = []
    rows = Recording.objects.filter(robot=robot, state__in=SHOWN).select_related("grant").order_by("-began_at")
    rows = rows.exclude(grant__in=JobRun.objects.filter(job__user=None).values("grant"))
    for recording in rows[:LOOKED]:
        about = access.about(recording, request.user)
        if about is not None and about.public:
            found.append(Listed(recording, about))
    lapses = Movie.objects.filter(robot=robot, day__isnull=False).order_by("-day", "kind")[:LISTED]
    yesterday = (SYSTEM.now() - timedelta(days=1)).date()
    context = {
        "robot": robot, "found": found[:LISTED], "turns": offers_turns(robot), "yesterday": yesterday,
        "lapses": lapses, "arriving": any(one.open for one in lapses),
    }  # fmt: skip
    return render(request, "recordings/list.html", context)


@never_cache
@require_safe
def replay(request: HttpRequest, key: str) -> HttpResponse:
    """Show a recording: the robot's console without controls, and a bar to move in time."""
    recording, about = access.visible(key, request.user, with_file=False)
    robot = recording.robot
    movies = movies_of(recording)
    second, said = moment_in(request.GET.get("t", ""), recording)
    context: dict[str, Any] = {
        "card": card_tags(recording, about, second), "second": second, "site": settings.SITE_ADDRESS,
        "recording": recording, "about": about, "robot": robot, "words": access.words_for(recording),
        "view": recording.replayable, "movies": movies, "replaying": True,
        "arriving": any(one["movie"] is not None and one["movie"].open for one in movies),
    }  # fmt: skip
    if recording.replayable:
        try:
            context |= {
                **console_context(robot, None),
                "replay_json": _facts(recording, about) | {"start": second * 1000, "said": said},
            }
        except (LookupError, ImportError, OSError):
            return software_missing(request, robot.name)
    answer = render(request, "recordings/replay.html", context)
    if about is None or not about.public:
        answer["X-Robots-Tag"] = "noindex, nofollow"
    return answer


def _facts(recording: Recording, about: access.About | None) -> dict[str, Any]:
    return {
        "index": f"{recording.get_absolute_url()}{recording.version}/index.json",
        "slices": f"{recording.get_absolute_url()}{recording.version}/",
        "slug": recording.robot.slug, "name": recording.robot.full_name, "who": about.who if about else "",
    }  # fmt: skip


def readable(request: HttpRequest, key: str, version: int) -> Recording:
    """Return the recording in this version, if this person may see it. Raises Http404."""
    recording, _ = access.visible(key, request.user)
    if version != recording.version:
        raise Http404("The recording was changed; reload its page.")
    return recording


def index_of(recording: Recording) -> "Index | None":
    """Return the index of a recording, from the cache if it is there; None if others are read now. Raises Http404."""
    name = f"{INDEX}:{recording.pk}:{recording.version}"
    stored = cache.get(name)
    if stored is None:
        if not COLD.acquire(timeout=COLD_S):
            return None
        try:
            stored = cache.get(name) or _read(recording)  # somebody may have read it meanwhile
        finally:
            COLD.release()
        cache.set(name, stored, 600)
    from robots.kit.recording.timeline import Index  # noqa: PLC0415 - the reader is loaded when it is needed

    return msgspec.json.decode(stored, type=Index)


def _read(recording: Recording) -> str:
    from robots.kit.recording.timeline import read_index  # noqa: PLC0415 - see index_of

    try:
        return msgspec.json.encode(read_index(keeping.path_of(recording))).decode()
    except OSError as error:
        raise Http404("The recording's file is gone.") from error


def busy() -> HttpResponse:
    """Return the answer while others read recordings."""
    return HttpResponse(BUSY, status=503, content_type="text/plain", headers={"Retry-After": "5"})


@require_safe
@limit_rate()
def index(request: HttpRequest, key: str, version: int) -> HttpResponse:
    """Return what happened when, as JSON."""
    found = index_of(readable(request, key, version))
    if found is None:
        return busy()
    told = msgspec.to_builtins(found)
    del told["places"], told["topics"]  # they are for `part`
    answer = HttpResponse(msgspec.json.encode(told), content_type="application/json")
    answer["Cache-Control"] = FOR_GOOD
    return answer


@require_safe
@limit_rate("slices")
def part(request: HttpRequest, key: str, version: int, number: int) -> HttpResponse:
    """Return a slice: the packets of five seconds."""
    from robots.kit.recording.timeline import read_slice  # noqa: PLC0415 - see index_of

    recording = readable(request, key, version)
    known = index_of(recording)
    if known is None:
        return busy()
    if number >= len(known.needs):
        raise Http404("The recording is shorter.")
    joints, channels = _names(recording.robot)
    try:
        data = read_slice(keeping.path_of(recording), known, number, joints, channels)
    except OSError as error:
        raise Http404("The recording cannot be read.") from error
    whole = len(known.places) == len(known.needs)  # else the slice may contain more
    return HttpResponse(data, content_type=MCAP, headers={"Cache-Control": FOR_GOOD if whole else "no-store"})


def _names(robot: Robot) -> tuple[tuple[str, ...], list[str]]:
    try:
        spec = robot.spec()
    except LookupError as error:
        raise Http404("The robot's software is not installed.") from error
    return spec.joints, [channel.name for channel in spec.packed()]


@never_cache
@require_safe
@limit_rate()
def download(request: HttpRequest, key: str) -> HttpResponseBase:
    """Return the recording's file, for programs that read MCAP."""
    recording, _ = access.visible(key, request.user)
    name = f"{recording.robot.slug}-{recording.began_at:%Y%m%d-%H%M%S}.mcap"
    return file_response(request, keeping.path_of(recording), MCAP, name)
