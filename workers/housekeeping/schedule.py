"""The scheduler of the housekeeping worker: a thread of it, where Celery's own `-B` is a process of 60 MB."""

import os
from typing import Any

from celery import bootsteps
from celery.beat import EmbeddedService


class Schedule(bootsteps.StartStopStep):
    """Send the periodic tasks while this worker lives; FARHAND_SCHEDULE names the file that keeps their times."""

    requires = ("celery.worker.components:Pool",)

    def __init__(self, worker: Any, **kwargs: Any) -> None:
        self._file = os.environ.get("FARHAND_SCHEDULE", "")
        self.enabled = bool(self._file)
        super().__init__(worker, **kwargs)

    def create(self, worker: Any) -> Any:
        """Return the thread; it is started after the pool and stopped before it."""
        return EmbeddedService(worker.app, thread=True, schedule_filename=self._file)
