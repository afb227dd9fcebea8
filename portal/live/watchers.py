"""The number of people who watch a robot: its operator is left out, and a person with several pages is one.

Each web process tells the others through Redis who watches there. Each page of a stranger counts.
"""

from collections.abc import Collection, Iterable
from contextlib import suppress
from typing import NamedTuple

from redis.exceptions import RedisError

from robots import bus

COUNT_S = 8  # a count of watchers that is older is of a web process that has ended


class Watchers(NamedTuple):
    """The watchers of one web process: pages of strangers, keys of people who are signed in, time of the count (s)."""

    strangers: int
    people: frozenset[int]
    at: int = 0

    def text(self) -> str:
        """Return the watchers as one text, for other processes."""
        return " ".join(map(str, (self.strangers, self.at, *sorted(self.people))))


def read_watchers(data: bytes) -> Watchers:
    """Return the watchers of another process; nobody, long ago, if its text is not understood."""
    try:
        strangers, at, *people = map(int, data.split())
    except ValueError:
        return Watchers(0, frozenset())
    return Watchers(strangers, frozenset(people), at)


def together(several: Iterable[Watchers]) -> int:
    """Return how many watch in several processes."""
    known = list(several)
    return sum(one.strangers for one in known) + len(frozenset[int]().union(*(one.people for one in known)))


def watchers_text(count: int) -> str:
    """Return the message that tells how many watch."""
    return f'{{"t": "watchers", "count": {count}}}'


def watching_now(slugs: Collection[str]) -> dict[str, int]:
    """Return how many watch each of these robots in all web processes; nothing while Redis is away."""
    with suppress(RedisError, OSError):
        both = bus.connection().pipeline(transaction=False)
        both.time()
        for slug in slugs:
            both.hgetall(bus.watchers_key(slug))
        (now, _), *told = both.execute()
        here = ([one for one in map(read_watchers, counts.values()) if now - one.at <= COUNT_S] for counts in told)
        return {slug: together(ones) for slug, ones in zip(slugs, here, strict=True)}
    return {}
