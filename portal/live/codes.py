"""One-time codes: each opens the operator's stream once, for one person, robot and grant, within half a minute.

Redis keeps a code's digest with its bearer. GETDEL reads and deletes both in one step: if the same code is used twice
at the same time, in whichever web processes, one use is refused.
"""

import contextlib
import hashlib
import re
import secrets
from datetime import datetime
from typing import Any

import msgspec
from redis.exceptions import RedisError

from robots import bus
from robots.grants import held_by, open_grant
from robots.kit.contract.errors import GrantOver
from robots.models import Grant, Robot
from robots.states import GrantKind

CODE_S = 30  # from asking to opening, over a slow line too
OPENED_S = 10  # so long after it was opened the end of the page's other socket is no absence
FORM = re.compile(r"[\w-]{43}", re.ASCII)
SPENT = "This code was used before, or is too old. The page asks for another one."
ANOTHERS = "This code is for somebody else."
ELSEWHERE = "This code is for another robot."
TURN_OVER = "The turn of this stream is over."
UNKNOWN = "The code cannot be checked now. The page asks for another one."


class CodeRefused(Exception):
    """The stream is not opened; the text says why."""


class Bearer(msgspec.Struct, frozen=True):
    """The bearer of a code: the keys of the person and of the grant, and the robot's slug."""

    user: int
    grant: int
    slug: str


def grant_driven(robot: Robot, user: Any, now: datetime) -> Grant:
    """Return the open grant under which the person drives the robot. Raises GrantOver."""
    grant = open_grant(robot)
    drives = user.is_authenticated and grant is not None and grant.kind != GrantKind.UPKEEP  # many have no holder
    return held_by(grant if drives else None, user, now)


def give(robot: Robot, user: Any, now: datetime) -> str:
    """Return a fresh code for the person who drives the robot. Raises GrantOver, RedisError."""
    meant = Bearer(user.pk, grant_driven(robot, user, now).pk, robot.slug)
    code = secrets.token_urlsafe(32)
    bus.connection().set(_key(code), msgspec.json.encode(meant), ex=CODE_S)
    return code


def use(code: str, slug: str, user: Any, now: datetime) -> int:
    """Spend a code; return the key of the grant under which its bearer drives. Raises CodeRefused.

    A code that somebody else brings is spent, too.
    """
    meant = _take(code) if FORM.fullmatch(code) else None
    if meant is None:
        raise CodeRefused(SPENT)
    if user.pk != meant.user:
        raise CodeRefused(ANOTHERS)
    if slug != meant.slug:
        raise CodeRefused(ELSEWHERE)
    try:
        grant = grant_driven(Robot.objects.get(slug=slug), user, now)
    except (Robot.DoesNotExist, GrantOver) as error:
        raise CodeRefused(TURN_OVER) from error
    if grant.pk != meant.grant:
        raise CodeRefused(TURN_OVER)
    with contextlib.suppress(RedisError, OSError):
        bus.connection().set(bus.operator_key(slug, user.pk), 1, ex=OPENED_S)
    return grant.pk


def lately_opened(slug: str, user: int) -> bool:
    """Return whether that person has just opened the operator's stream."""
    try:
        return bool(bus.connection().exists(bus.operator_key(slug, user)))
    except (RedisError, OSError):
        return False


def _key(code: str) -> str:
    return bus.code_key(hashlib.sha256(code.encode()).hexdigest())


def _take(code: str) -> Bearer | None:
    """Return the bearer of a code and delete it; None if Redis has no such code. Raises CodeRefused."""
    try:
        stored: Any = bus.connection().getdel(_key(code))
    except (RedisError, OSError) as error:
        raise CodeRefused(UNKNOWN) from error
    return msgspec.json.decode(stored, type=Bearer) if stored is not None else None
