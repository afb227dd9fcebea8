"""Access to recordings: a person may see as much of a recording as of the turn or job that it shows."""

import re
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from django.http import Http404
from django.utils.timezone import localtime
from django.utils.translation import gettext

from operatorlog.models import Entry, Visibility
from queueing.models import Job, Turn
from queueing.services import label_of
from robots.dates import date_words
from robots.models import Recording, RecordingState
from robots.people import driver_name, is_person, shown_name
from robots.sentences import translate

NONE = "There is no such recording."
DATED = re.compile(r"(\d{1,2} [A-Z][a-z]+ \d{4}): (.*)", re.DOTALL)  # the reason for a removal, as it is stored


@dataclass(frozen=True)
class About:
    """The turn or the job of a recording. `quiet`: search engines are asked to leave it out."""

    title: str
    who: str
    url: str
    quiet: bool
    hidden: bool

    @property
    def public(self) -> bool:
        """Return whether lists may show it to everybody."""
        return not self.quiet and not self.hidden


def about(recording: Recording, viewer: Any = None) -> About | None:
    """Return what a recording shows, with names as the viewer may read them; None if its turn or job was deleted."""
    turn = Turn.objects.select_related("user").filter(grant=recording.grant_id).first()
    if turn is not None:
        hidden = Entry.objects.filter(turn=turn, visibility=Visibility.HIDDEN).exists()
        name = driver_name(turn.user, viewer)
        return About(
            gettext("Turn of {name}").format(name=shown_name(name)), name, turn.get_absolute_url(), False, hidden
        )
    job = Job.objects.select_related("user", "robot").filter(runs__grant=recording.grant_id).first()
    if job is not None:
        title = gettext("{label} (a job)").format(label=translate(label_of(job.robot, job.kind)))
        return About(title, job.shown_name, job.get_absolute_url(), job.user is None, False)
    return None


def may_see(recording: Recording, about: About | None, user: Any) -> bool:
    """Return whether this person may replay it: staff always, others unless its log entry was hidden by a moderator.

    A recording whose turn or job was deleted is for staff alone.
    """
    if user.has_perm("robots.view_recording") or user.has_perm("robots.change_robot"):
        return True
    if about is None:
        return False
    return not about.hidden or is_person(user, recording.grant.holder_id)


def visible(key: str, user: Any, with_file: bool = True) -> tuple[Recording, About | None]:
    """Return the recording at an address, with its turn or job. `with_file`: it has to have a file. Raises Http404."""
    recording = Recording.objects.select_related("robot", "grant").filter(key=key).first()
    if recording is None or (with_file and not recording.replayable):
        raise Http404(NONE)
    found = about(recording, user)
    if not may_see(recording, found, user):
        raise Http404(NONE)
    return recording, found


def to_offer(grants: Any, user: Any) -> list[Recording]:
    """Return the recordings of these grants that a page may mention to this person: ready, running or removed."""
    found = Recording.objects.filter(grant__in=grants).select_related("robot", "grant").order_by("id")
    return [one for one in found if may_see(one, about(one), user)]


def words_for(recording: Recording) -> str:
    """Return what to say of a recording, in the reader's language."""
    if recording.state == RecordingState.RUNNING:
        return gettext("It is being recorded.")
    if recording.state == RecordingState.REMOVED:
        removed = gettext("The recording was removed.")
        return f"{removed} {_reason(recording)}".strip()
    left_out = gettext("The disk was too slow: some pictures were left out.") if recording.dropped else ""
    kept = gettext("Kept until {day} at most, less if space is needed.")
    said = (kept.format(day=date_words(localtime(recording.kept_until))), _reason(recording), left_out)
    return " ".join(part for part in said if part)


def _reason(recording: Recording) -> str:
    dated = DATED.fullmatch(recording.reason)
    if dated is None:
        return translate(recording.reason)
    try:
        day = datetime.strptime(dated[1], "%d %B %Y").date()  # noqa: DTZ007 - a day has no zone
    except ValueError:
        return translate(recording.reason)
    return f"{date_words(day)}: {translate(dated[2])}"
