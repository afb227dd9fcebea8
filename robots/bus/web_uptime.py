"""Since when people can reach the portal: a web process runs, and database and Redis answer it.

Nobody can say that they are present while they cannot, so no absence of that time counts.
"""

import contextlib
from datetime import UTC, datetime

from redis.exceptions import RedisError

from robots.bus import names, store

TELL_S, LASTS_S = 2.0, 7  # the key ends `LASTS_S` after the last web process; its value is when the first began


def tell(now: datetime) -> bool:
    """Note that a web process runs. Return False if Redis did not answer."""
    try:
        if not store.connection().set(names.web_up_key(), now.timestamp(), ex=LASTS_S, nx=True):
            store.connection().expire(names.web_up_key(), LASTS_S)
    except (RedisError, OSError):
        return False
    return True


def up_since(now: datetime) -> datetime:
    """Return since when people can reach the portal; `now` while they cannot."""
    try:
        told = store.connection().get(names.web_up_key())
    except (RedisError, OSError):
        return now
    return datetime.fromtimestamp(float(told), UTC) if isinstance(told, bytes) else now


def forget() -> None:
    """Count from now on, for the time of day was set."""
    with contextlib.suppress(RedisError, OSError):
        store.connection().delete(names.web_up_key())
