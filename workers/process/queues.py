"""Removes from Redis the Celery queues of a robot's earlier owners, which would stay there for ever."""

import contextlib

import redis

from robots import bus

# a queue's messages, and the sets by which Celery's library knows where messages go
STARTS = ("", "_kombu.binding.", "_kombu.binding_permanent.")


def forget_earlier(slug: str, epoch: int) -> None:
    """Remove the queues of earlier epochs; their messages are wake-ups for owners that are gone.

    A later one is of the next owner, which may have begun meanwhile.
    """
    every = bus.queue_name(slug, 0).removesuffix("0")
    with contextlib.suppress(redis.RedisError, OSError):  # the next owner makes up for it
        store = bus.connection()
        found = [key.decode() for start in STARTS for key in store.scan_iter(f"{start}{every}*", count=1000)]
        if old := [key for key in found if (number := key.rpartition(".")[2]).isdecimal() and int(number) < epoch]:
            store.delete(*old)
