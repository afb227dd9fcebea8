"""What the Celery queues of a robot's earlier owners have left in Redis, where it would stay for ever."""

import contextlib

import redis

from robots import bus

# a queue's messages, and the sets by which Celery's library knows where messages go
STARTS = ("", "_kombu.binding.", "_kombu.binding_permanent.")


def forget_earlier(slug: str, epoch: int) -> None:
    """Remove the queues of all other epochs; their messages are wake-ups for owners that are gone."""
    ours = bus.queue_name(slug, epoch)
    every = bus.queue_name(slug, 0).removesuffix("0")
    kept = {f"{start}{ours}" for start in STARTS}
    with contextlib.suppress(redis.RedisError, OSError):  # the next owner makes up for it
        store = bus.connection()
        found = [key.decode() for start in STARTS for key in store.scan_iter(f"{start}{every}*", count=1000)]
        if old := [key for key in found if key not in kept]:
            store.delete(*old)
