"""The outlet of log lines: a thread writes them, so that neither a full nor a slow log delays the program."""

import contextlib
import logging
import os
import select
import threading
from collections import deque

ROOM = 500_000  # bytes that may wait; further lines are left out and counted
FLUSH_S = 1.0  # the longest wait for them when a process ends


class Outlet:
    """Writes lines to a file descriptor. Thread safe; never blocks and never raises; a fork begins with none."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._begin()
        os.register_at_fork(after_in_child=self._begin)

    def _begin(self) -> None:
        self._changed = threading.Condition()
        self._waiting: deque[bytes] = deque()
        self._size = 0
        self._lost = 0
        self._busy = False
        self._thread: threading.Thread | None = None

    def write(self, line: str) -> None:
        """Have a line written, unless too many wait already."""
        data = f"{line}\n".encode(errors="backslashreplace")
        with self._changed:
            if self._size + len(data) > ROOM:
                self._lost += 1
                return
            self._waiting.append(data)
            self._size += len(data)
            self._changed.notify_all()
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="log", daemon=True)
                try:
                    self._thread.start()
                except RuntimeError:  # no thread can start now; the next line tries again
                    self._thread = None

    def flush(self, seconds: float = FLUSH_S) -> bool:
        """Wait until everything is written. Return whether it is."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._waiting and not self._busy, seconds)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._busy = False
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._waiting)
                data, lost = b"".join(self._waiting), self._lost
                self._waiting.clear()
                self._size, self._lost, self._busy = 0, 0, True
            if lost:
                data += b"%d lines of the log were left out: it was full or too slow\n" % lost
            left = self._put(data)
            if left:
                with self._changed:
                    self._lost += lost + left.count(b"\n") - bool(lost)

    def _put(self, data: bytes) -> bytes:
        """Write. Return the bytes that could not be written, because nobody reads them any more or the disk is full."""
        while data:
            try:
                data = data[os.write(self._descriptor, data) :]
            except BlockingIOError:  # another process that shares the descriptor made it non-blocking
                with contextlib.suppress(OSError):
                    select.select((), (self._descriptor,), ())
            except OSError:
                return data
        return data


ERRORS = Outlet(2)  # standard error


class Console(logging.Handler):
    """Writes records to standard error by `ERRORS`."""

    def emit(self, record: logging.LogRecord) -> None:
        """Have a record written."""
        try:
            ERRORS.write(self.format(record))
        except Exception as error:  # noqa: BLE001 - Python's own way writes at once, arguments of any size, too
            ERRORS.write(f"{record.pathname}:{record.lineno} has logged what has no text: {type(error).__name__}")

    def flush(self) -> None:
        """Wait until everything is written, at most `FLUSH_S`."""
        ERRORS.flush()
