"""The housekeeping worker's scheduler, as a thread; Celery's own `-B` is a process of 60 MB."""

import logging
import os
import signal
from datetime import datetime, timedelta
from threading import Thread
from typing import Any

from celery import bootsteps
from celery.beat import PersistentScheduler, ScheduleEntry, Service

from robots.kit.clock import SYSTEM

log = logging.getLogger(__name__)
LONGEST_S = 1.0  # between two looks at what is due
STOP_S = 5.0  # for the end of a scheduler that cannot write its file, as on a full disk


_BEGAN, _BEGAN_AT = SYSTEM.now(), SYSTEM.awake()


def even_now() -> datetime:
    """Return a time that goes on evenly, whatever the time of day is set to: Celery's schedules compare it alone."""
    return _BEGAN + timedelta(seconds=SYSTEM.awake() - _BEGAN_AT)


class Entry(ScheduleEntry):  # type: ignore[misc]
    """A periodic task that stays due when the time of day is set."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.schedule.nowfun = even_now
        # the file may be of a time when the date was wrong
        self.last_run_at: datetime = min(self.last_run_at, even_now())


class EvenScheduler(PersistentScheduler):  # type: ignore[misc]
    """Celery's scheduler, which keeps its times in a file, with such entries."""

    Entry = Entry


class Scheduler(Thread):
    """Sends the periodic tasks; `file` keeps their times.

    A scheduler that fails ends its worker, which the supervisor starts again: without ticks no queue would move, and
    Celery's own thread would end in silence, and keep the worker from ending for ever.
    """

    def __init__(self, app: Any, file: str) -> None:
        super().__init__(name="scheduler", daemon=True)
        self._app, self._stopping = app, False
        self._service = Service(app, max_interval=LONGEST_S, schedule_filename=file, scheduler_cls=EvenScheduler)

    def run(self) -> None:
        """Send tasks until `stop`."""
        self._app.set_current()
        try:
            self._service.start()
        except Exception:
            log.exception("the scheduler failed")
        if not self._stopping:
            os.kill(os.getpid(), signal.SIGTERM)

    def stop(self) -> None:
        """Stop soon; the times are kept if they can be."""
        self._stopping = True
        self._service.stop()
        self.join(STOP_S)


class Schedule(bootsteps.StartStopStep):
    """Send the periodic tasks while this worker lives; FARHAND_SCHEDULE names the file that keeps their times."""

    requires = ("celery.worker.components:Pool",)

    def __init__(self, worker: Any, **kwargs: Any) -> None:
        self._file = os.environ.get("FARHAND_SCHEDULE", "")
        self.enabled = bool(self._file)
        super().__init__(worker, **kwargs)

    def create(self, worker: Any) -> Any:
        """Return the thread; Celery starts it after the pool and stops it before the pool."""
        return Scheduler(worker.app, self._file)
