"""Messages to everybody who watches: events, states, pictures, sound; and to a robot's owner: wake-ups, stops.

The database is the truth; a message only makes a reader look sooner. Failures are counted and answered with False; they
are not raised. Where an event was lost, pages are told to read again: with the next message of that robot, or soon.
"""

import contextlib
import json
import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import redis
from celery import current_app
from django.db import transaction

from robots.bus import names, store
from robots.kit.packets import Changed, Event, StandingChanged, encode

_lost: set[str] = set()  # robots of which this process could not send an event


def reach(channel: str, data: bytes) -> int:
    """Return the number of listeners; -1 if Redis is away."""
    try:
        return int(store.connection().publish(channel, data))
    except (redis.RedisError, OSError):
        store.failures["publish"] += 1
        return -1


def send(channel: str, data: bytes) -> bool:
    """Send data. Return False if Redis did not answer."""
    return reach(channel, data) >= 0


def publish(slug: str, event: Event) -> bool:
    """Send an event to everybody who watches the robot. Return False if Redis did not answer."""
    sent = send(names.events_channel(slug), encode(event))
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

    Each process that runs for long calls it every few seconds.
    """
    for slug in list(_lost):
        _make_up(slug)


def publish_on_commit(slug: str, event: Event) -> None:
    """Send an event after the transaction has committed."""
    transaction.on_commit(lambda: publish(slug, event), robust=True)


def tell_people_on_commit(event: StandingChanged) -> None:
    """Tell people's sockets, after the transaction has committed, that their places changed."""
    transaction.on_commit(lambda: send(names.people_channel(), encode(event)), robust=True)


def send_session_changed(person: int) -> bool:
    """Tell every web process that something about a person's session, account or clearance changed."""
    return send(names.sessions_channel(), b"%d" % person)


def publish_state(slug: str, packet: bytes) -> bool:
    """Send a state packet. Return whether somebody listens."""
    listeners = reach(names.state_channel(slug), packet)
    if listeners >= 0:
        _make_up(slug)
    return listeners > 0


def publish_compact(slug: str, packet: bytes) -> bool:
    """Send a state to those who want it compact."""
    return send(names.compact_channel(slug), packet)


def publish_path(slug: str, packet: bytes, left_s: float) -> bool:
    """Send the path on which a robot moves now, and keep it for who comes later, for so long (s)."""
    try:
        both = store.connection().pipeline(transaction=True)
        both.set(names.path_key(slug), packet, px=max(1, round(1000 * left_s)))
        both.publish(names.path_channel(slug), packet)
        both.execute()
    except (redis.RedisError, OSError):
        store.failures["publish"] += 1
        return False
    return True


def forget_path(slug: str) -> None:
    """Keep a robot's path no longer: its motion has ended."""
    with contextlib.suppress(redis.RedisError, OSError):  # it ends by itself
        store.connection().delete(names.path_key(slug))


def publish_sound(slug: str, packet: bytes) -> bool:
    """Send a packet of sound to those who listen; it is kept for nobody."""
    return send(names.channel_of(slug, names.SOUND), packet)


def publish_picture(slug: str, packet: bytes, camera: int = 0, coarse: bool = False) -> bool:
    """Send a picture."""
    return send(names.frames_channel(slug, camera, coarse), packet)


def publish_video(slug: str, packet: bytes, camera: int = 0, coarse: bool = False) -> bool:
    """Send a packet of video."""
    return send(names.video_channel(slug, camera, coarse), packet)


def publish_trace(slug: str, event: Event) -> bool:
    """Send a line of the wire trace."""
    return send(names.trace_channel(slug), encode(event))


def wake_owner(slug: str, epoch: int, lane: str = "") -> bool:
    """Tell the owner that command rows may wait, all of them in one lane if it is named. False: Redis did not answer.

    The message goes over pub/sub; if nobody listens there, it goes over the Celery queue, where it waits.
    A wake-up carries no command, so one that arrives twice changes nothing.
    """
    try:
        if store.connection().publish(names.wake_channel(slug), lane or "wake"):
            return True
        current_app.send_task(names.WAKE_TASK, queue=names.queue_name(slug, epoch), ignore_result=True, retry=False)
    except Exception:  # noqa: BLE001 - kombu raises many kinds; a lost wake-up costs 100 ms
        store.failures["wake"] += 1
        return False
    return True


def send_stop(slug: str, grant: int = 0) -> bool:
    """Tell the owner to stop. An operator's stop names the grant under which it was pressed."""
    return send(names.stop_channel(slug), b"stop %d" % grant if grant else b"stop")


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
    return send(names.held_channel(slug), b"held %d %d%b" % (command, held, values))


def read_keep_alive(data: bytes) -> KeepAlive:
    """Return what a keep-alive says. Raises ValueError, also for one of an earlier version."""
    found = re.fullmatch(rb"held ([0-9]{1,18}) ([01])(?: (\{[ -~]{1,3000}\}))?", data)
    if found is None:
        raise ValueError("not a keep-alive")
    args = json.loads(found[3]) if found[3] else {}
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in args.values()):
        raise ValueError("not a keep-alive: its values are numbers")
    return KeepAlive(int(found[1]), found[2] == b"1", args)


def wake_probes() -> bool:
    """Wake the housekeeping worker: a test of a robot waits in the database. Return False if that failed."""
    try:
        current_app.send_task(names.PROBE_TASK, queue=names.PROBES, ignore_result=True, retry=False)
    except Exception:  # noqa: BLE001 - see wake_owner
        store.failures["housekeeping"] += 1
        return False
    return True
