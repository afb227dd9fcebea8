"""Live pictures that have an address of their own for a minute, in Redis."""

import redis

from robots import bus


def keep_shot(slug: str, camera: int, at_ms: int, jpeg: bytes) -> bool:
    """Keep a live picture for `bus.SHOT_S`. Return False if Redis did not answer."""
    try:
        bus.connection().set(bus.shot_key(slug, camera, at_ms), jpeg, ex=bus.SHOT_S, nx=True)
    except (redis.RedisError, OSError):
        bus.failures["shot"] += 1
        return False
    return True


def shot(slug: str, camera: int, at_ms: int) -> bytes | None:
    """Return a live picture that is kept; None if there is none, or Redis does not answer."""
    try:
        found: bytes | None = bus.connection().get(bus.shot_key(slug, camera, at_ms))  # type: ignore[assignment]
    except (redis.RedisError, OSError):
        bus.failures["shot"] += 1
        return None
    return found


def drop_shot(slug: str, camera: int, at_ms: int) -> bool:
    """Remove a live picture that is kept. Return False if Redis did not answer."""
    try:
        bus.connection().delete(bus.shot_key(slug, camera, at_ms))
    except (redis.RedisError, OSError):
        bus.failures["shot"] += 1
        return False
    return True
