"""Messages to a robot's owner: wake-ups, stops, keep-alives; and wake-ups of the housekeeping worker."""

import json
import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from celery import current_app

from robots.bus import names, store
from robots.bus.publishing import send


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
