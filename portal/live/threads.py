"""Threads for the ORM beside the event loop: several, so that one slow call delays no other socket."""

from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

from channels.db import database_sync_to_async

P = ParamSpec("P")
R = TypeVar("R")
_POOL = ThreadPoolExecutor(8, thread_name_prefix="orm")


def orm(function: Callable[P, R]) -> Callable[P, Coroutine[Any, Any, R]]:
    """Return `function` as a coroutine function that runs in a thread with a database connection."""
    made: Callable[P, Coroutine[Any, Any, R]] = database_sync_to_async(function, thread_sensitive=False, executor=_POOL)
    return made
