"""All names of Redis keys, channels and Celery queues, and all messages sent over them.

The database is the truth; a message only makes a reader look sooner. Failures are counted and answered with False; they
are not raised. Where an event was lost, pages are told to read again: with the next message of that robot, or soon.
"""

import json
import logging
import re
from collections import Counter
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

import redis
from celery import current_app
from django.conf import settings
from django.db import transaction

from robots.kit.packets import Changed, Event, StandingChanged, encode

log = logging.getLogger(__name__)
failures: Counter[str] = Counter()
_lost: set[str] = set()  # robots of which this process could not send an event
WAKE_TASK = "robots.wake"
PROBE_TASK = "robots.probe"
HOUSEKEEPING, TICKS, PROBES = "housekeeping", "ticks", "probes"  # of the housekeeping worker, one queue each
WATCH_S = 4
OPEN_S = 3.0  # for a connection for pub/sub, with all that Redis has to answer until it is open
SOUND = "sound"  # what is watched by somebody who listens
SLOW_S = 1.0  # who wants a picture only so often, or less often, does not make a camera capture more
RARELY_S, RARE_S = 5.0, 2.52  # who wants one in 5 s or less often is given the second of pictures that come so often
SOME_S = 0.2  # of recordings


def queue_name(slug: str, epoch: int) -> str:
    """Return the Celery queue of the owner with that epoch."""
    return f"robot.{slug}.{epoch}"


def events_channel(slug: str) -> str:
    """Return the channel of a robot's events."""
    return f"farhand:{slug}:events"


def channel_of(slug: str, what: str) -> str:
    """Return the channel of what is watched: `state`, `trace`, or what `watched_as` returns."""
    return f"farhand:{slug}:{what.partition('.')[0]}"


def frames_of(camera: int, coarse: bool = False) -> str:
    """Return the name of a camera's stream: `frames` for the first, `frames1`, `frames2`...; `coarse`, `coarse1`..."""
    return f"{'coarse' if coarse else 'frames'}{camera or ''}"


def video_of(camera: int, coarse: bool = False) -> str:
    """Return the name of a camera's video: `video` for the first, `video1`, `video2`...; `coarsevideo`..."""
    return f"{'coarse' if coarse else ''}video{camera or ''}"


def key_of(camera: int, coarse: bool = False) -> str:
    """Return what a web process asks for that needs a key picture of a camera's video."""
    return f"{video_of(camera, coarse)}.key"


def watched_as(camera: int, every_s: float, video: bool = False, coarse: bool = False) -> str:
    """Return what is watched by somebody who wants a camera's picture at most once in `every_s` seconds.

    `video`, `coarse`: as video, or in few bytes, where each picture is wanted.
    """
    if every_s:
        rates = ((RARELY_S, ".rare"), (SLOW_S, ".slow"), (SOME_S, ".some"))
        return frames_of(camera) + next((name for least_s, name in rates if every_s >= least_s), "")
    return video_of(camera, coarse) if video else frames_of(camera, coarse)


def frames_channel(slug: str, camera: int = 0, coarse: bool = False) -> str:
    """Return the channel of a camera's pictures."""
    return f"farhand:{slug}:{frames_of(camera, coarse)}"


def video_channel(slug: str, camera: int = 0, coarse: bool = False) -> str:
    """Return the channel of a camera's video."""
    return f"farhand:{slug}:{video_of(camera, coarse)}"


def state_channel(slug: str) -> str:
    """Return the channel of a robot's state packets."""
    return f"farhand:{slug}:state"


def compact_channel(slug: str) -> str:
    """Return the channel of a robot's compact states, for slow lines."""
    return f"farhand:{slug}:compact"


def stream_channel(slug: str) -> str:
    """Return the channel of a robot's byte streams."""
    return f"farhand:{slug}:stream"


def trace_channel(slug: str) -> str:
    """Return the channel of a robot's wire trace, for staff."""
    return f"farhand:{slug}:trace"


def stop_channel(slug: str) -> str:
    """Return the channel that stops a robot; it passes no queue."""
    return f"farhand:{slug}:stop"


def wake_channel(slug: str) -> str:
    """Return the channel that wakes the owner; a message is lost if nobody listens."""
    return f"farhand:{slug}:wake"


def held_channel(slug: str) -> str:
    """Return the channel of keep-alives of a held motion."""
    return f"farhand:{slug}:held"


def people_channel() -> str:
    """Return the channel that says whose places in queues changed."""
    return "farhand:people"


def sessions_channel() -> str:
    """Return the channel that carries the ids of people whose session, account or clearance may have changed."""
    return "farhand:sessions"


def send_session_changed(person: int) -> bool:
    """Tell every web process that something about a person's session, account or clearance changed."""
    return _publish(sessions_channel(), b"%d" % person)


def watch_key(slug: str, what: str) -> str:
    """Return the key that exists while somebody watches."""
    return f"farhand:{slug}:watch:{what}"


_given: list[redis.Redis] = []  # what this process speaks through instead of a server, if it was given something


def speak_through(store: redis.Redis | None) -> None:
    """Speak through this store from now on, for short calls and for pub/sub; None: through the server again."""
    _given[:] = [] if store is None else [store]


def connection() -> redis.Redis:
    """Return this process's connection pool for short calls."""
    return _given[0] if _given else _pool()


@cache
def _pool() -> redis.Redis:
    return redis.Redis.from_url(
        settings.REDIS_URL,
        socket_timeout=settings.REDIS_TIMEOUT_S,
        socket_connect_timeout=settings.REDIS_TIMEOUT_S,
        retry=None,
    )


def listener() -> redis.Redis:
    """Return a connection for pub/sub: opened within `OPEN_S`; who listens finds out by pings that it is gone."""
    if _given:
        return _given[0]
    return redis.Redis.from_url(settings.REDIS_URL, socket_timeout=OPEN_S, socket_connect_timeout=1.0, retry=None)


def _send(channel: str, data: bytes) -> int:
    """Return the number of listeners; -1 if Redis is away."""
    try:
        return int(connection().publish(channel, data))
    except (redis.RedisError, OSError):
        failures["publish"] += 1
        return -1


def _publish(channel: str, data: bytes) -> bool:
    return _send(channel, data) >= 0


def publish(slug: str, event: Event) -> bool:
    """Send an event to everybody who watches the robot. Return False if Redis did not answer."""
    sent = _publish(events_channel(slug), encode(event))
    if sent:
        _make_up(slug)
    else:
        _lost.add(slug)
    return sent


def _make_up(slug: str) -> None:
    """Have pages read again what a lost event would have told them; Redis answers again."""
    if slug in _lost:
        _lost.discard(slug)
        publish(slug, Changed("robot"))


def lost_events() -> bool:
    """Return whether this process lost an event that was not made up for."""
    return bool(_lost)


def make_up() -> None:
    """Have pages read again where this process lost an event, though it has nothing to tell of that robot now.

    Whatever runs for long calls it every few seconds.
    """
    for slug in list(_lost):
        _make_up(slug)


def publish_on_commit(slug: str, event: Event) -> None:
    """Send an event after the transaction has committed."""
    transaction.on_commit(lambda: publish(slug, event), robust=True)


def tell_people_on_commit(event: StandingChanged) -> None:
    """Tell people's sockets, after the transaction has committed, that their places changed."""
    transaction.on_commit(lambda: _publish(people_channel(), encode(event)), robust=True)


def publish_state(slug: str, packet: bytes) -> bool:
    """Send a state packet. Return whether somebody listens."""
    listeners = _send(state_channel(slug), packet)
    if listeners >= 0:
        _make_up(slug)
    return listeners > 0


def publish_compact(slug: str, packet: bytes) -> bool:
    """Send a state to those who want it compact."""
    return _publish(compact_channel(slug), packet)


def publish_sound(slug: str, packet: bytes) -> bool:
    """Send a packet of sound to those who listen; it is kept for nobody."""
    return _publish(channel_of(slug, SOUND), packet)


def publish_picture(slug: str, packet: bytes, camera: int = 0, coarse: bool = False) -> bool:
    """Send a picture."""
    return _publish(frames_channel(slug, camera, coarse), packet)


def publish_video(slug: str, packet: bytes, camera: int = 0, coarse: bool = False) -> bool:
    """Send a packet of video."""
    return _publish(video_channel(slug, camera, coarse), packet)


def publish_trace(slug: str, event: Event) -> bool:
    """Send a line of the wire trace."""
    return _publish(trace_channel(slug), encode(event))


def wake_owner(slug: str, epoch: int, lane: str = "") -> bool:
    """Tell the owner that command rows may wait, all of them in one lane if it is named. False: Redis did not answer.

    The message goes over pub/sub; if nobody listens there, it goes over the Celery queue, where it waits.
    A wake-up carries no command, so one that arrives twice changes nothing.
    """
    try:
        if connection().publish(wake_channel(slug), lane or "wake"):
            return True
        current_app.send_task(WAKE_TASK, queue=queue_name(slug, epoch), ignore_result=True, retry=False)
    except Exception:  # noqa: BLE001 - kombu raises many kinds; a lost wake-up costs 100 ms
        failures["wake"] += 1
        return False
    return True


def send_stop(slug: str, grant: int = 0) -> bool:
    """Tell the owner to stop. An operator's stop names the grant under which it was pressed."""
    return _publish(stop_channel(slug), b"stop %d" % grant if grant else b"stop")


def grant_of_stop(data: bytes) -> int:
    """Return the grant that a stop names; 0 if it names none or cannot be read. Such a stop always counts."""
    _, _, grant = data.partition(b" ")
    return int(grant) if re.fullmatch(rb"[0-9]{1,18}", grant) else 0


class KeepAlive(NamedTuple):
    """The controls of a command (its key) are still `held`, or were released; `args`: newer values of it."""

    command: int
    held: bool
    args: dict[str, int | float] = {}


def send_keep_alive(
    slug: str, command: int, held: bool, args: Mapping[str, int | float] = MappingProxyType({})
) -> bool:
    """Tell the owner that the controls of a command are still held, or were released."""
    values = b" " + json.dumps(dict(args)).encode() if args else b""
    return _publish(held_channel(slug), b"held %d %d%b" % (command, held, values))


def read_keep_alive(data: bytes) -> KeepAlive:
    """Return what a keep-alive says. Raises ValueError, also for one of an earlier version."""
    found = re.fullmatch(rb"held ([0-9]{1,18}) ([01])(?: (\{[ -~]{1,3000}\}))?", data)
    if found is None:
        raise ValueError("not a keep-alive")
    args = json.loads(found[3]) if found[3] else {}
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in args.values()):
        raise ValueError("not a keep-alive: its values are numbers")
    return KeepAlive(int(found[1]), found[2] == b"1", args)


def watch(slug: str, what: str = "frames") -> bool:
    """Note that somebody watches, for the next `WATCH_S` seconds. Return False if Redis did not answer."""
    try:
        connection().set(watch_key(slug, what), 1, ex=WATCH_S)
    except (redis.RedisError, OSError):
        failures["watch"] += 1
        return False
    return True


def watched(slug: str, what: str = "frames") -> bool:
    """Return whether somebody watches. Raises redis.RedisError."""
    return bool(connection().exists(watch_key(slug, what)))


class Wanted(NamedTuple):
    """What somebody wants of a camera, whole and coarse: each picture, video, a key picture of it.

    `some`: one picture in `SOME_S` seconds; `now_and_then`: one in `SLOW_S` seconds; `rarely`: one in `RARE_S` seconds.
    """

    each: bool = False
    video: bool = False
    key: bool = False
    coarse: bool = False
    coarse_video: bool = False
    coarse_key: bool = False
    some: bool = False
    now_and_then: bool = False
    rarely: bool = False


def how_watched(slug: str, camera: int) -> Wanted:
    """Return what somebody wants of a camera. Raises redis.RedisError."""
    names = [name(camera, coarse) for coarse in (False, True) for name in (frames_of, video_of, key_of)]
    names += [watched_as(camera, SOME_S), watched_as(camera, SLOW_S), watched_as(camera, RARELY_S)]
    return Wanted(*(found is not None for found in connection().mget(*(watch_key(slug, name) for name in names))))


def key_comes(slug: str, camera: int, coarse: bool = False) -> None:
    """Note that a key picture of a camera's video is on its way: nobody has to ask for it any more."""
    try:
        connection().delete(watch_key(slug, key_of(camera, coarse)))
    except (redis.RedisError, OSError):
        failures["watch"] += 1


def watchers_key(slug: str) -> str:
    """Return the hash that holds how many watch a robot in each web process, and when that was counted (s)."""
    return f"farhand:{slug}:watchers"


def web_key() -> str:
    """Return the key that exists while a web process runs; without one nobody notes who watches."""
    return "farhand:web"


def may_be_watched(slug: str) -> bool:
    """Return whether somebody watches; True also while Redis or all web processes are away, for then nobody knows."""
    try:
        looked = connection().exists(*(watch_key(slug, what) for what in ("frames", "state")))
        return bool(looked) or not connection().exists(web_key())
    except (redis.RedisError, OSError):
        return True


def alive() -> bool:
    """Return whether Redis answers."""
    try:
        return bool(connection().ping())
    except (redis.RedisError, OSError):
        return False


def wake_probes() -> bool:
    """Wake the housekeeping worker: a test of a robot waits in the database. Return False if that failed."""
    try:
        current_app.send_task(PROBE_TASK, queue=PROBES, ignore_result=True, retry=False)
    except Exception:  # noqa: BLE001 - see wake_owner
        failures["housekeeping"] += 1
        return False
    return True
