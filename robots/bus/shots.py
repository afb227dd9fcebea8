"""Live pictures that have an address of their own for a minute, in Redis."""

import redis

from robots.bus import names, store

SHOT_S = 60


def keep_shot(slug: str, camera: int, at_ms: int, jpeg: bytes) -> bool:
    """Keep a live picture for `SHOT_S` (s). Return False if Redis did not answer."""
    try:
        store.connection().set(names.shot_key(slug, camera, at_ms), jpeg, ex=SHOT_S, nx=True)
    except (redis.RedisError, OSError):
        store.failures["shot"] += 1
        return False
    return True


def shot(slug: str, camera: int, at_ms: int) -> bytes | None:
    """Return a live picture that is kept; None if there is none, or Redis does not answer."""
    try:
        found: bytes | None = store.connection().get(names.shot_key(slug, camera, at_ms))  # type: ignore[assignment]
    except (redis.RedisError, OSError):
        store.failures["shot"] += 1
        return None
    return found


def drop_shots(slug: str, camera: int, at_ms: int, near_ms: int) -> bool:
    """Remove the live pictures that were taken within `near_ms` of `at_ms`. Return False if Redis did not answer."""
    try:
        redis_store = store.connection()
        times = [names.time_of_shot(key) for key in redis_store.scan_iter(names.shot_key(slug, camera, "*"))]
        if near := [names.shot_key(slug, camera, ms) for ms in times if abs(ms - at_ms) <= near_ms]:
            redis_store.delete(*near)
    except (redis.RedisError, OSError):
        store.failures["shot"] += 1
        return False
    return True
