"""The owner's threads. Each runs its loop for as long as the owner lives, or ends it by failing again and again."""

import logging
import threading
from collections.abc import Callable

import redis
from django.db import Error, close_old_connections

from workers.owned import OwnedRobot

log = logging.getLogger(__name__)
PAUSE_S = 0.5
FAILURES = 3
WELL_S = 10.0  # a loop that ran so long before it failed had been well


class Threads:
    """Begins loops and goes on with one that failed, until it fails `FAILURES` times in a row.

    Then `end` is called with the reason: it holds the robot and ends the owner, which its supervisor starts anew.
    """

    def __init__(self, owned: OwnedRobot, end: Callable[[str], None]) -> None:
        self._owned, self._end = owned, end
        self._threads: list[threading.Thread] = []

    def begin(self, name: str, loop: Callable[[], None]) -> None:
        """Run `loop` in a thread of that name."""
        thread = threading.Thread(target=self._guarded, args=(name, loop), name=name, daemon=True)
        thread.start()
        self._threads.append(thread)

    def join(self, name: str, seconds: float) -> None:
        """Wait for the end of the thread of that name, at most `seconds` (s)."""
        for thread in self._threads:
            if thread.name == name:
                thread.join(seconds)

    def _guarded(self, name: str, loop: Callable[[], None]) -> None:
        """Run a loop for as long as we live; a store that is down is waited for."""
        owned, failed = self._owned, 0
        while owned.running:
            begun = owned.clock.monotonic()
            try:
                loop()
            except (Error, redis.RedisError) as error:
                log.warning("%s: a store does not answer: %s", name, error)
                close_old_connections()
            except Exception:
                failed = 1 if owned.clock.monotonic() - begun > WELL_S else failed + 1
                log.exception("%s failed, %d of %d times in a row", name, failed, FAILURES)
                if failed == FAILURES:
                    self._end(f"its thread {name!r} failed {FAILURES} times in a row")
                    return
            else:
                continue
            owned.clock.sleep(PAUSE_S)
