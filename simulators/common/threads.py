"""What becomes of a thread that dies of an error: the journal tells it, and the simulator ends."""

import os
import sys
import threading

from simulators.common.journal import Journal


def record_deaths(journal: Journal) -> None:
    """Write each thread that ends by an exception as `thread_died`; the traceback goes to stderr as usual."""
    told = threading.excepthook

    def hook(args: threading.ExceptHookArgs) -> None:
        journal.note("thread_died", thread=args.thread.name if args.thread else "", error=repr(args.exc_value))
        told(args)

    threading.excepthook = hook


def end_with_any() -> None:
    """From now on end this process, with exit status 1 and a line on stderr, once one of its threads dies of an error.

    Called by a process before it starts a thread, and before `record_deaths`.
    """
    told = threading.excepthook

    def hook(args: threading.ExceptHookArgs) -> None:
        told(args)
        name = args.thread.name if args.thread else ""
        sys.stderr.write(f"the simulator ends, because its thread {name!r} died: {args.exc_value!r}\n")
        sys.stderr.flush()
        os._exit(1)  # as at a loss of power: other threads may wait for the one that died

    threading.excepthook = hook


def names() -> list[str]:
    """Return the names of the live threads."""
    return sorted(thread.name for thread in threading.enumerate())
