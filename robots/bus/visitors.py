"""Counts different network addresses a day without storing any: a HyperLogLog of hashes, keyed with a salt of the day.

The salt is random and in Redis alone. It and the counts end an hour after the day, and then nobody can find out whether
an address was among those that were counted.
"""

import hashlib
import secrets
from collections.abc import Collection, Mapping
from datetime import UTC, date, datetime, time, timedelta

from robots.bus import names, store

PORTAL = 0  # the number of the whole portal; others are primary keys of robots
AFTER = timedelta(hours=1)  # the day's last addresses are counted a minute late
AT_ONCE = 2000  # hashes of one call, which Redis answers within its timeout
SALT_BYTES = HASH_BYTES = 16


def last_moment(day: date) -> datetime:
    """Return until when addresses of that day can be counted."""
    return datetime.combine(day + timedelta(days=1), time(), UTC) + AFTER


def count_addresses(day: date, seen_by: Mapping[int, Collection[str]], now: datetime) -> tuple[dict[int, int], bool]:
    """Count these addresses, by robot or `PORTAL`. Return how many different ones each has that day, about 1 % off.

    The second value says whether counting has begun with this call: Redis had no salt of that day.

    Raises:
        redis.RedisError, OSError: Redis did not answer; some may be counted, and may be given again.
        ValueError: the day is over, and its salt is gone.
    """
    until = last_moment(day)
    if now >= until:
        raise ValueError(f"{day} is over")
    redis, salt_key = store.connection(), names.visitors_key(day, "salt")
    began = bool(redis.set(salt_key, secrets.token_bytes(SALT_BYTES), exat=until, nx=True))
    salt = redis.get(salt_key)
    if not isinstance(salt, bytes):
        raise ConnectionError("Redis lost the salt of the day")
    counts = {}
    for which, addresses in seen_by.items():
        key, hashes = names.visitors_key(day, str(which)), [_hash(one, salt) for one in addresses]
        for first in range(0, len(hashes), AT_ONCE):
            redis.pfadd(key, *hashes[first : first + AT_ONCE])
        redis.expireat(key, until)
        counts[which] = int(redis.pfcount(key))
    return counts, began


def _hash(address: str, salt: bytes) -> bytes:
    return hashlib.blake2b(address.encode("utf-8", "replace"), digest_size=HASH_BYTES, key=salt).digest()
