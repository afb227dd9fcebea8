"""The page with a robot's newest recordings."""

from dataclasses import dataclass
from datetime import timedelta

from django.http import HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404, render
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_safe

from portal.web.pages.serving import limited
from portal.web.recordings import access
from queueing.models import JobRun
from queueing.services import offers_turns
from robots.kit.clock import SYSTEM
from robots.models import Movie, Recording, Robot
from robots.models.recordings import SHOWN

LISTED, LOOKED = 20, 60
LONGEST = timedelta(hours=12)  # of a turn or a job


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
            return "not known: the time of day was set"
        minutes, seconds = divmod(int(passed.total_seconds()), 60)
        return f"{minutes}:{seconds:02}"


@never_cache
@require_safe
def recordings_of(request: HttpRequest, slug: str) -> HttpResponse:
    """List what everybody may see, without jobs of guests, whose addresses they alone were given."""
    refused = limited(request)
    if refused is not None:
        return refused
    robot = get_object_or_404(Robot, slug=slug)
    found: list[Listed] = []
    rows = Recording.objects.filter(robot=robot, state__in=SHOWN).select_related("grant").order_by("-began_at")
    rows = rows.exclude(grant__in=JobRun.objects.filter(job__user=None).values("grant"))
    for recording in rows[:LOOKED]:
        about = access.about(recording)
        if about is not None and not about.quiet and not about.hidden:
            found.append(Listed(recording, about))
    lapses = Movie.objects.filter(robot=robot, day__isnull=False).order_by("-day", "kind")[:LISTED]
    yesterday = (SYSTEM.now() - timedelta(days=1)).date()
    context = {"lapses": lapses, "arriving": any(one.open for one in lapses), "yesterday": yesterday} | {
        "robot": robot,
        "found": found[:LISTED],
        "turns": offers_turns(robot),
    }
    return render(request, "recordings/list.html", context)
