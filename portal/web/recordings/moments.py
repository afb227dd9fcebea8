"""A moment of a recording: the second in a link, and the tags by which other sites show a card of it."""

from datetime import timedelta
from math import isfinite

from django.utils.safestring import SafeString
from django.utils.timezone import localtime
from django.utils.translation import gettext, gettext_lazy

from portal.web.pages.cards import tags
from portal.web.recordings import access
from robots.dates import date_words
from robots.models import Recording

LONGEST = timedelta(hours=12)  # of a turn or a job
NO_TIME = gettext_lazy("The link names no time in this recording, so it begins at the start.")


def length_s(recording: Recording) -> int:
    """Return the length of a recording in whole seconds; 0 where the time of day was set meanwhile."""
    ended = recording.ended_at or recording.began_at
    passed = (ended - recording.began_at).total_seconds()
    return int(passed) if 0 <= passed < LONGEST.total_seconds() else 0


def moment_in(text: str, recording: Recording) -> tuple[int, str]:
    """Return the second that `?t=` names, and what to say if it names none."""
    try:
        at = float(text[:20]) if text else 0.0
    except ValueError:
        return 0, str(NO_TIME)
    if not isfinite(at) or not 0 <= at <= length_s(recording):
        return 0, str(NO_TIME)
    return int(at), ""


def picture_address(recording: Recording, second: int) -> str:
    """Return the address of the picture of a moment, without the site."""
    return f"{recording.get_absolute_url()}{recording.version}/moment-{second}.jpg"


def card_tags(recording: Recording, about: access.About | None, second: int) -> SafeString:
    """Return the Open Graph tags of a recording that everybody may see; nothing for others."""
    if about is None or not about.public or not recording.replayable:
        return SafeString("")
    day = date_words(localtime(recording.began_at))
    return tags(
        recording.get_absolute_url() + (f"?t={second}" if second else ""),
        gettext("{title} on {robot}").format(title=about.title, robot=recording.robot.full_name),
        gettext("A recording of {day}, to be looked at from this moment on.").format(day=day),
        picture_address(recording, second),
        gettext("What the camera of {robot} saw at that moment").format(robot=recording.robot.name),
    )
