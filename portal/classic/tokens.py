"""The rotating tokens of the console without scripts: each is good for at most one motion."""

import secrets
from datetime import datetime, timedelta
from typing import Any

from queueing.models import ClassicToken
from robots.models import Robot


def fresh_token(robot: Robot, user: Any, now: datetime, still: int = 0) -> str:
    """Make the next token of the console without scripts.

    A page that is fetched ahead gets one too, so earlier ones stay good until one is spent.
    """
    token = secrets.token_urlsafe(24)
    ClassicToken.objects.create(token=token, user=user, robot=robot, made_at=now, still=still)
    ClassicToken.objects.filter(user=user, made_at__lt=now - timedelta(days=1)).delete()
    return token


def spend_token(robot: Robot, user: Any, token: str, now: datetime) -> ClassicToken | None:
    """Spend a token: returns it to the one request that was first, None to all others.

    All other pages that this person has open for the robot are spent with it: after a
    motion a step back in the browser moves nothing.
    """
    mine = ClassicToken.objects.filter(user=user, robot=robot)
    if not mine.filter(token=token, spent_at=None).update(spent_at=now):
        return None
    mine.filter(spent_at=None).update(spent_at=now)
    return mine.get(token=token)
