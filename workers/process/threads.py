"""The owner's threads: each repeats its loop until the owner ends; a loop that keeps failing ends the owner.

So does any other thread of its process that dies of an error, a driver's or a camera's, because nothing is to go on
without it unnoticed.
"""

import contextlib
import logging
import threading
import traceback
from collections.abc import Callable
from functools import partial

import redis
from django.db import Error, close_old_connections

from workers.robot.owned import OwnedRobot

log = logging.getLogger(__name__)
PAUSE_S, FAILURES = 0.5, 3
WELL_S = 10.0  # a loop that ran this long before it failed counts as having worked


class Threads:
    """Starts loops and repeats those that fail, until one fails `FAILURES` times in a row.

    Then `end` is called with the reason, while the error is handled: it holds the robot, logs both and ends the owner;
    the supervisor starts a new one.
    """

    def __init__(self, owned: OwnedRobot, end: Callable[[str], None]) -> None:
        self._owned, self._end = owned, end
        self._threads: list[threading.Thread] = []

    def begin(self, name: str, loop: Callable[[], None]) -> None:
        """Run `loop` in a thread of that name."""
        self._threads.append(self._owned.clock.spawn(partial(self._guarded, name, loop), name))

    def join(self, name: str, seconds: float) -> None:
        """Wait at most `seconds` (s) for the thread of that name."""
        for thread in self._threads:
            if thread.name == name:
                thread.join(seconds)

    def end_with_any(self) -> None:
        """From now on end the owner once a thread of this process dies of an error."""

        def hook(args: threading.ExceptHookArgs) -> None:
            said = "".join(traceback.format_exception_only(args.exc_value)).strip()  # of an error without a text, too
            why = f"its thread {args.thread.name if args.thread else ''!r} died: {said}"
            if self._owned.running:
                self._end(why)  # before anything is written; its log has the traceback
            else:
                log.error("the owner has ended already, and %s", why, exc_info=args.exc_value)

        threading.excepthook = hook

    def _guarded(self, name: str, loop: Callable[[], None]) -> None:
        """Repeat a loop until the owner ends; while a store is down, wait for it."""
        owned, failed = self._owned, 0
        while owned.running:
            begun = owned.clock.monotonic()
            try:
                loop()
            except (Error, redis.RedisError) as error:
                log.warning("%s: a store does not answer: %s", name, error)
                with contextlib.suppress(Error):  # a connection may fail once more when it is closed
                    close_old_connections()
            except Exception:
                failed = 1 if owned.clock.monotonic() - begun > WELL_S else failed + 1
                log.exception("%s failed, %d of %d times in a row", name, failed, FAILURES)
                if failed == FAILURES:
                    self._end(f"its thread {name!r} failed {FAILURES} times in a row")
                    return
            else:  # it went round
                failed = 0
                continue
            owned.clock.sleep(PAUSE_S)
