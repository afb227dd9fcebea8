"""A thread that dies of an error is written into the journal: a simulator must not limp on unseen."""

import threading

from simulators.common.journal import Journal


def record_deaths(journal: Journal) -> None:
    """Note each thread that ends by an exception as `thread_died`; the traceback goes to the error output as ever."""
    told = threading.excepthook

    def hook(args: threading.ExceptHookArgs) -> None:
        journal.note("thread_died", thread=args.thread.name if args.thread else "", error=repr(args.exc_value))
        told(args)

    threading.excepthook = hook


def names() -> list[str]:
    """Return the names of the threads that live."""
    return sorted(thread.name for thread in threading.enumerate())
