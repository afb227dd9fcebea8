"""The Celery tasks of a robot: the wake-up, the test of a connection, the removal of old pictures."""

from celery import shared_task
from celery.worker import state

from robots import bus, probes
from robots.clock import SYSTEM
from workers import bootstep
from workers.housekeeping.clean import old_frames


@shared_task(name="robots.wake", ignore_result=True, max_retries=0)
def wake() -> None:
    """Answer the wake-up: the owner looks at its command rows."""
    if bootstep.owner is not None:
        bootstep.owner.wake()


@shared_task(name=bus.PROBE_TASK, ignore_result=True, max_retries=0)
def probe() -> None:
    """Carry out the tests that are asked for, one at a time; who comes meanwhile has nothing to do."""
    if probes.waiting():
        from workers.housekeeping.probe import all_that_wait  # noqa: PLC0415 - cameras and their libraries

        all_that_wait(lambda: state.should_stop is not None)


@shared_task(name="robots.clean", ignore_result=True, max_retries=0)
def clean() -> int:
    """Remove pictures past their time that nothing refers to; return how many."""
    return old_frames(SYSTEM.now())
