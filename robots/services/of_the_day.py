"""The decision of staff on the movie of the day."""

from typing import Any

from django.db import transaction

from robots.kit.clock import SYSTEM
from robots.models import Movie, Recording
from robots.models.recordings import OfTheDay
from robots.recordings import movies
from robots.services.permissions import need_staff


def choose_of_the_day(recording: Recording, choice: OfTheDay, user: Any) -> bool:
    """Say whether a recording's movie is the movie of the day, never is, or is by the rule.

    At most one is pinned; an MP4 movie of it is made where there is none. Return False if that was said before.
    Raises NotStaff; BadRequest where there is nothing to pin.
    """
    need_staff(user)
    with transaction.atomic():
        if choice == OfTheDay.PINNED:
            movies.ask(recording, Movie.Kind.MP4, SYSTEM.now())
            others = Recording.objects.filter(of_the_day=OfTheDay.PINNED).exclude(pk=recording.pk)
            others.update(of_the_day=OfTheDay.BY_RULE)
        changed = Recording.objects.filter(pk=recording.pk).exclude(of_the_day=choice).update(of_the_day=choice)
    return bool(changed)
