"""The progress of a long command, stored and published no more often than people can read."""

import logging
import math
from typing import Any

from django.db import Error, close_old_connections

from robots import bus
from robots.grants import stage_event
from robots.kit.contract.session import Progress
from robots.models import Command
from robots.states import COMMAND_FINAL
from workers.robot.owned import OwnedRobot

log = logging.getLogger(__name__)
EVERY_S = 0.5
LONGEST = 120


class ProgressReporter:
    """Stores and publishes progress; a report that comes sooner than `EVERY_S` after the last one is dropped."""

    def __init__(self, owned: OwnedRobot) -> None:
        self._owned = owned
        self._last: tuple[int, float] = (0, 0.0)  # the command, and the time (monotonic, s)

    def report(self, command: Command, progress: Progress) -> None:
        """Store and publish it. If the database is away, this report is lost and the command goes on."""
        now = self._owned.clock.monotonic()
        told, at = self._last
        if told == command.pk and now - at < EVERY_S:
            return
        self._last = (command.pk, now)
        command.progress = record(progress, int(self._owned.now().timestamp() * 1000))
        try:
            running = Command.objects.filter(pk=command.pk).exclude(state__in=COMMAND_FINAL)
            if not running.update(progress=command.progress):
                return
        except Error as error:
            log.warning("progress of %s is lost: %s", command, error)
            close_old_connections()
        bus.publish(command.robot.slug, stage_event(command))


def record(progress: Progress, at_ms: int) -> dict[str, Any]:
    """Return the stored form: a short text, a share from 0 to 1 or None, and the time (ms since 1970)."""
    share = progress.share
    known = isinstance(share, int | float) and math.isfinite(share)
    return {
        "text": str(progress.text)[:LONGEST],
        "share": round(min(max(float(share), 0.0), 1.0), 3) if share is not None and known else None,
        "at_ms": at_ms,
    }
