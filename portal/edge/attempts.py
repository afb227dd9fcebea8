"""Rate limits of requests (`RATE_LIMITS`), counted for all web processes together."""

from allauth.core.internal.ratelimit import get_cache_key, get_rates
from django.conf import settings
from django.core.cache import cache
from django.http import HttpRequest


def within(request: HttpRequest, action: str, key: str | None = None) -> bool:
    """Count a request. Return whether it is within each limit of the action; `key`: what is counted "by key".

    allauth's own `consume` refuses a request that waits a second for the lock under which it counts; so it refuses
    simultaneous requests far below the limit. This counts in one step, from the first request on.
    """
    rates = get_rates(app="farhand", action=action, config=settings.RATE_LIMITS)
    counts = [
        _counted(get_cache_key(request, app="farhand-count", action=action, rate=rate, key=key), rate.duration)
        for rate in rates
    ]
    return all(count <= rate.amount for count, rate in zip(counts, rates, strict=True))


def _counted(name: str, seconds: float) -> int:
    for _ in range(2):
        if cache.add(name, 1, seconds):
            return 1
        try:
            count = cache.incr(name)
        except ValueError:  # it has just run out
            continue
        if count == 1:  # it ran out between two steps of `incr`, which then begins one that never does
            cache.touch(name, seconds)
        return count
    return 1
