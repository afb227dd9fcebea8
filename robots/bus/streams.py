"""Byte streams on the bus: packets are sent, and the store keeps those that newcomers need."""

import redis

from robots.bus import names, store

STREAM_S = 30  # an owner that is gone leaves its byte streams behind for so long


def publish_stream(slug: str, stream: int, packets: list[bytes], from_key: bool) -> bool:
    """Send packets of a byte stream and keep them for who comes later, together or not at all.

    `from_key`: the first is a key packet, which replaces the packets that were kept.
    """
    key = names.stream_key(slug, stream)
    try:
        both = store.connection().pipeline(transaction=True)
        if from_key:
            both.delete(key)
            both.rpush(key, *packets)
        else:
            both.rpushx(key, *packets)  # type: ignore[arg-type]
        both.expire(key, STREAM_S)
        for packet in packets:
            both.publish(names.stream_channel(slug), packet)
        both.execute()
    except (redis.RedisError, OSError):
        store.failures["publish"] += 1
        return False
    return True


def kept_stream(slug: str, stream: int) -> list[bytes] | None:
    """Return the newest key packet of a byte stream and the deltas after it; None without Redis."""
    try:
        kept: list[bytes] = store.connection().lrange(names.stream_key(slug, stream), 0, -1)  # type: ignore[assignment]
    except (redis.RedisError, OSError):
        return None
    return kept


def keep_stream(slug: str, stream: int) -> bool:
    """Keep the packets of a byte stream for another while; False if they are there no more."""
    try:
        return bool(store.connection().expire(names.stream_key(slug, stream), STREAM_S))
    except (redis.RedisError, OSError):
        return True  # it is asked again soon
