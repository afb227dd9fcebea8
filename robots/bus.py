"""The only place that names a Redis key, a channel or a Celery queue.

Redis is a doorbell: everything here may fail without anything being lost. Failures are
counted and answered with False, never raised to a person.
"""

import logging
import re
from collections import Counter
from functools import cache

import redis
from celery import current_app
from django.conf import settings
from django.db import transaction

from robots.messages import Event, StandingChanged, encode

log = logging.getLogger(__name__)
failures: Counter[str] = Counter()
RING_TASK = "robots.look"
PROBE_TASK = "robots.probe"
HOUSEKEEPING, TICKS, PROBES = "housekeeping", "ticks", "probes"  # of the housekeeping worker, one queue each
WATCH_S = 4


def queue_name(slug: str, epoch: int) -> str:
    """Return the Celery queue of the owner with that epoch."""
    return f"robot.{slug}.{epoch}"


def events_channel(slug: str) -> str:
    """Return the channel of a robot's events."""
    return f"farhand:{slug}:events"


def frames_of(camera: int) -> str:
    """Return the name of a camera's stream: `frames` for the first, `frames1`, `frames2`..."""
    return f"frames{camera or ''}"


def frames_channel(slug: str, camera: int = 0) -> str:
    """Return the channel of a camera's pictures."""
    return f"farhand:{slug}:{frames_of(camera)}"


def state_channel(slug: str) -> str:
    """Return the channel of a robot's state packets."""
    return f"farhand:{slug}:state"


def trace_channel(slug: str) -> str:
    """Return the channel of a robot's wire trace, for keepers."""
    return f"farhand:{slug}:trace"


def stop_channel(slug: str) -> str:
    """Return the channel that stops a robot, round every queue."""
    return f"farhand:{slug}:stop"


def bell_channel(slug: str) -> str:
    """Return the quick bell's channel: lost where nobody listens, unlike the queue's."""
    return f"farhand:{slug}:bell"


def held_channel(slug: str) -> str:
    """Return the channel of keep-alives of a held motion."""
    return f"farhand:{slug}:held"


def people_channel() -> str:
    """Return the channel that says whose standing changed."""
    return "farhand:people"


def sessions_channel() -> str:
    """Return the channel on which a person's id means: look whether they may still be here, and say so if they are."""
    return "farhand:sessions"


def ring_session(person: int) -> bool:
    """Tell every web process that something about a person's session, account or clearance changed."""
    return _publish(sessions_channel(), b"%d" % person)


def watch_key(slug: str, what: str) -> str:
    """Return the key that says somebody looks."""
    return f"farhand:{slug}:watch:{what}"


@cache
def connection() -> redis.Redis:
    """Return this process's connection pool for short calls."""
    return redis.Redis.from_url(
        settings.REDIS_URL,
        socket_timeout=settings.REDIS_TIMEOUT_S,
        socket_connect_timeout=settings.REDIS_TIMEOUT_S,
        retry=None,
    )


def listener() -> redis.Redis:
    """Return a connection for pub/sub: no read timeout, checked by pings of its own."""
    return redis.Redis.from_url(settings.REDIS_URL, socket_timeout=None, socket_connect_timeout=1.0, retry=None)


def _send(channel: str, data: bytes) -> int:
    """Return how many listened; -1 where Redis is away."""
    try:
        return int(connection().publish(channel, data))
    except (redis.RedisError, OSError):
        failures["publish"] += 1
        return -1


def _publish(channel: str, data: bytes) -> bool:
    return _send(channel, data) >= 0


def publish(slug: str, event: Event) -> bool:
    """Tell everybody who watches the robot."""
    return _publish(events_channel(slug), encode(event))


def publish_on_commit(slug: str, event: Event) -> None:
    """Tell everybody once the transaction is through."""
    transaction.on_commit(lambda: publish(slug, event), robust=True)


def tell_people_on_commit(event: StandingChanged) -> None:
    """Tell the sockets of people, once the transaction is through, that they stand elsewhere."""
    transaction.on_commit(lambda: _publish(people_channel(), encode(event)), robust=True)


def publish_state(slug: str, packet: bytes) -> bool:
    """Send a state packet; tell whether somebody listens."""
    return _send(state_channel(slug), packet) > 0


def publish_picture(slug: str, packet: bytes, camera: int = 0) -> bool:
    """Send a picture."""
    return _publish(frames_channel(slug, camera), packet)


def publish_trace(slug: str, event: Event) -> bool:
    """Send a line of the wire trace."""
    return _publish(trace_channel(slug), encode(event))


def ring(slug: str, epoch: int) -> bool:
    """Ring the owner's quick bell; the queue's, which waits for a busy one, where nobody heard.

    Both mean "look"; hearing both, or one of them twice, changes nothing.
    """
    try:
        if connection().publish(bell_channel(slug), b"look"):
            return True
        current_app.send_task(RING_TASK, queue=queue_name(slug, epoch), ignore_result=True, retry=False)
    except Exception:  # noqa: BLE001 - kombu raises a zoo; a lost ring costs 100 ms, no more
        failures["ring"] += 1
        return False
    return True


def ring_stop(slug: str, grant: int = 0) -> bool:
    """Tell the owner to stop, on a channel of its own; an operator's stop names the grant it is pressed under."""
    return _publish(stop_channel(slug), b"stop %d" % grant if grant else b"stop")


def heard_stop(data: bytes) -> int:
    """Return the grant that a stop names; 0 where it names none, or none that can be read: it always stops."""
    _, _, grant = data.partition(b" ")
    return int(grant) if re.fullmatch(rb"[0-9]{1,18}", grant) else 0


def keep(slug: str, user: int, seq: int, held: bool) -> bool:
    """Say that the operator's controls are still held, or were let go."""
    return _publish(held_channel(slug), b"%d %d %d" % (user, seq, held))


def heard_keep(data: bytes) -> tuple[int, int, bool]:
    """Return (user, sequence number, held) of a keep-alive. Raises ValueError."""
    user, seq, held = (int(part) for part in data.split())
    return user, seq, bool(held)


def watch(slug: str, what: str = "frames") -> bool:
    """Say that somebody looks; holds for a few seconds."""
    try:
        connection().set(watch_key(slug, what), 1, ex=WATCH_S)
    except (redis.RedisError, OSError):
        failures["watch"] += 1
        return False
    return True


def watched(slug: str, what: str = "frames") -> bool:
    """Tell whether somebody looks. Raises redis.RedisError."""
    return bool(connection().exists(watch_key(slug, what)))


def web_key() -> str:
    """Return the key that says that a web process lives which would tell who looks."""
    return "farhand:web"


def perhaps_watched(slug: str) -> bool:
    """Tell whether somebody looks, or cannot be heard to: with Redis or every web process silent, nobody is known."""
    try:
        looked = connection().exists(*(watch_key(slug, what) for what in ("frames", "state")))
        return bool(looked) or not connection().exists(web_key())
    except (redis.RedisError, OSError):
        return True


def alive() -> bool:
    """Tell whether Redis answers."""
    try:
        return bool(connection().ping())
    except (redis.RedisError, OSError):
        return False


def ring_probes() -> bool:
    """Tell the housekeeping worker that a test of a robot was asked for; it finds out which."""
    try:
        current_app.send_task(PROBE_TASK, queue=PROBES, ignore_result=True, retry=False)
    except Exception:  # noqa: BLE001 - see ring
        failures["housekeeping"] += 1
        return False
    return True
