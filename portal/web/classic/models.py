"""The rotating tokens of the console without scripts: each allows at most one motion."""

import secrets
from datetime import datetime, timedelta
from typing import Any

from django.conf import settings
from django.db import models
from django.utils.translation import gettext, gettext_lazy

from robots.models import Robot

KEPT = timedelta(days=1)
SHARED = KEPT / 2  # so that a page that was just fetched has half a day left


class ClassicToken(models.Model):
    """A token: whose it is, for which robot, and whether it is spent."""

    token = models.CharField(max_length=44, unique=True)
    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, related_name="+")
    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="+")
    made_at = models.DateTimeField()
    spent_at = models.DateTimeField(null=True, blank=True)
    still = models.BigIntegerField(default=0, help_text=gettext_lazy("The picture that its page shows."))

    def __str__(self) -> str:
        return gettext("token of {user}").format(user=self.user)


def fresh_token(robot: Robot, user: Any, now: datetime, still: int = 0) -> str:
    """Return a token of the console without scripts that is not spent yet, for the page with this picture.

    Pages with the same picture share one, because spending any spends all. So a page that is fetched again and again,
    or in advance by the browser, adds no row.
    """
    mine = ClassicToken.objects.filter(user=user, robot=robot, still=still, spent_at=None, made_at__gt=now - SHARED)
    kept = mine.values_list("token", flat=True).first()
    if kept is not None:
        return kept
    token = secrets.token_urlsafe(24)
    ClassicToken.objects.create(token=token, user=user, robot=robot, made_at=now, still=still)
    ClassicToken.objects.filter(user=user, made_at__lt=now - KEPT).delete()
    return token


def spend_token(robot: Robot, user: Any, token: str, now: datetime) -> ClassicToken | None:
    """Spend a token. Return it to the first request, None to all others.

    All other tokens that this person has for the robot are spent with it, so that going back in the browser after a
    motion moves nothing.
    """
    mine = ClassicToken.objects.filter(user=user, robot=robot)
    if not mine.filter(token=token, spent_at=None).update(spent_at=now):
        return None
    mine.filter(spent_at=None).update(spent_at=now)
    return mine.get(token=token)
