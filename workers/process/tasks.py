"""Celery tasks: the wake-up of an owner, tests of connections, the time online, the removal of what is old."""

from celery import shared_task, signals
from celery.worker import state

from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.recordings import cleaning
from robots.services import probes
from robots.wall_clock import wall_clock
from workers.housekeeping.clean import old_frames, old_sessions
from workers.process import bootstep


@shared_task(name="robots.wake", ignore_result=True, max_retries=0)
def wake() -> None:
    """Make the owner look at its command rows."""
    if bootstep.owner is not None:
        bootstep.owner.wake()


@shared_task(name=bus.PROBE_TASK, ignore_result=True, max_retries=0)
def probe() -> None:
    """Carry out requested tests, one at a time; returns at once if another thread does so."""
    if probes.waiting():
        from workers.housekeeping.probe import all_that_wait  # noqa: PLC0415 - cameras and their libraries

        all_that_wait(lambda: state.should_stop is not None)


@shared_task(name="robots.clean", ignore_result=True, max_retries=0)
def clean() -> int:
    """Remove old pictures that nothing refers to, sessions that ran out, old recordings and counters. Return how many.

    While the date may be wrong nothing is old; what is too large goes in any case.
    """
    now = wall_clock().age_now
    return old_frames(now) + old_sessions(now) + cleaning.clean(now) + services.forget_old_usage(now)


@shared_task(name="robots.online", ignore_result=True, max_retries=0)
def online() -> None:
    """Count the time since the last call as online for each robot whose owner answers, and note outages."""
    global _looked
    last, _looked = _looked, SYSTEM.monotonic()
    services.note_online(SYSTEM.now(), _looked - last)
    services.note_outages(SYSTEM.now())


_looked = SYSTEM.monotonic()


@signals.worker_init.connect
def count_from_now(**_: object) -> None:
    """Count from now on: this module may have been loaded long before the worker started."""
    global _looked
    _looked = SYSTEM.monotonic()
