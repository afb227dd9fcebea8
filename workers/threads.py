"""The owner's threads. Each runs its loop for as long as the owner lives."""

import logging
import threading
from collections.abc import Callable

from django.db import Error, close_old_connections

from workers.owned import OwnedRobot

log = logging.getLogger(__name__)
PAUSE_S = 0.5


class Threads:
    """Begins loops and goes on with one that failed."""

    def __init__(self, owned: OwnedRobot) -> None:
        self._owned = owned
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
        while self._owned.running:
            try:
                loop()
            except Error as error:
                log.warning("%s: the database does not answer: %s", name, error)
                close_old_connections()
                self._owned.clock.sleep(PAUSE_S)
            except Exception:
                log.exception("%s failed and goes on", name)
                self._owned.clock.sleep(PAUSE_S)
