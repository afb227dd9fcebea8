"""Writes threads that die of an error into the journal, so that no simulator goes on without one unnoticed."""

import threading

from simulators.common.journal import Journal


def record_deaths(journal: Journal) -> None:
    """Write each thread that ends by an exception as `thread_died`; the traceback goes to stderr as usual."""
    told = threading.excepthook

    def hook(args: threading.ExceptHookArgs) -> None:
        journal.note("thread_died", thread=args.thread.name if args.thread else "", error=repr(args.exc_value))
        told(args)

    threading.excepthook = hook


def names() -> list[str]:
    """Return the names of the live threads."""
    return sorted(thread.name for thread in threading.enumerate())
