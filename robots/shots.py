"""Live pictures that have an address of their own for a minute, in Redis."""

import redis

from robots import bus

SHOT_S = 60


def _key(slug: str, camera: int, at_ms: int | str) -> str:
    return f"farhand:{slug}:shot:{camera}:{at_ms}"


def keep_shot(slug: str, camera: int, at_ms: int, jpeg: bytes) -> bool:
    """Keep a live picture for `SHOT_S` (s). Return False if Redis did not answer."""
    try:
        bus.connection().set(_key(slug, camera, at_ms), jpeg, ex=SHOT_S, nx=True)
    except (redis.RedisError, OSError):
        bus.failures["shot"] += 1
        return False
    return True


def shot(slug: str, camera: int, at_ms: int) -> bytes | None:
    """Return a live picture that is kept; None if there is none, or Redis does not answer."""
    try:
        found: bytes | None = bus.connection().get(_key(slug, camera, at_ms))  # type: ignore[assignment]
    except (redis.RedisError, OSError):
        bus.failures["shot"] += 1
        return None
    return found


def drop_shots(slug: str, camera: int, at_ms: int, near_ms: int) -> bool:
    """Remove the live pictures that were taken within `near_ms` of `at_ms`. Return False if Redis did not answer."""
    try:
        store, prefix = bus.connection(), _key(slug, camera, "")
        times = [int(bytes(key).decode().removeprefix(prefix)) for key in store.scan_iter(f"{prefix}*")]
        if near := [_key(slug, camera, ms) for ms in times if abs(ms - at_ms) <= near_ms]:
            store.delete(*near)
    except (redis.RedisError, OSError):
        bus.failures["shot"] += 1
        return False
    return True
