"""The housekeeping worker's scheduler, as a thread; Celery's own `-B` is a process of 60 MB."""

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
        """Return the thread; Celery starts it after the pool and stops it before the pool."""
        return EmbeddedService(worker.app, thread=True, schedule_filename=self._file)
