"""What happens when a thread dies of an error: the journal records it, and the simulator ends."""

import os
import signal
import sys
import threading

from simulators.common.journal import Journal

STDERR_S = 1  # longest wait until stderr takes a text; then SIGALRM ends the process


def record_deaths(journal: Journal) -> None:
    """Write each thread that ends by an exception as `thread_died`; the traceback goes to stderr as usual."""
    before = threading.excepthook

    def hook(args: threading.ExceptHookArgs) -> None:
        try:
            journal.note("thread_died", thread=args.thread.name if args.thread else "", error=repr(args.exc_value))
        finally:
            before(args)

    threading.excepthook = hook


def end_with_any() -> None:
    """End this process, with exit status 1 and a line on stderr, once one of its threads dies of an error.

    If nobody reads stderr, SIGALRM ends it. Call this before a thread is started, and before `record_deaths`.
    """
    before = threading.excepthook

    def hook(args: threading.ExceptHookArgs) -> None:
        signal.alarm(STDERR_S)
        try:
            before(args)
            name = args.thread.name if args.thread else ""
            sys.stderr.write(f"the simulator ends, because its thread {name!r} died: {args.exc_value!r}\n")
            sys.stderr.flush()
        finally:
            os._exit(1)  # as at a loss of power: other threads may wait for the one that died

    threading.excepthook = hook


def names() -> list[str]:
    """Return the names of the live threads."""
    return sorted(thread.name for thread in threading.enumerate())
