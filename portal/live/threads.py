"""Thread pools beside the event loop; strangers cannot occupy those of others.

People who stand in a queue and staff have a pool of their own, in which one person uses at most `EACH` threads. So
requests of strangers never delay a heartbeat. Operators have a pool that nobody else uses, so that a crowd that waits
delays no command. Urgent work that needs only Redis (stop, keep-alives) has another.
"""

import asyncio
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar
from weakref import WeakValueDictionary

from channels.db import database_sync_to_async

P = ParamSpec("P")
R = TypeVar("R")
EACH = 3


class Pool:
    """Threads for one kind of work; each person (by id) uses at most `EACH` at a time."""

    def __init__(self, name: str, threads: int) -> None:
        self._executor = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._people = WeakValueDictionary[tuple[int, int], asyncio.Semaphore]()  # of those with calls under way

    def orm(self, function: Callable[P, R], person: int = 0) -> Callable[P, Coroutine[Any, Any, R]]:
        """Return `function` as a coroutine function that runs in a thread with a database connection."""
        made: Callable[P, Coroutine[Any, Any, R]] = database_sync_to_async(
            function, thread_sensitive=False, executor=self._executor
        )

        async def run(*args: P.args, **kwargs: P.kwargs) -> R:
            if not person:
                return await made(*args, **kwargs)
            key = (id(asyncio.get_running_loop()), person)
            async with self._people.setdefault(key, asyncio.Semaphore(EACH)):
                return await made(*args, **kwargs)

        return run

    async def run(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Run a function without database access in a thread."""
        return await asyncio.get_running_loop().run_in_executor(self._executor, lambda: function(*args, **kwargs))


URGENT = Pool("urgent", 4)  # stop and keep-alives
DRIVERS = Pool("drivers", 4)  # people who hold a robot's grant, one a robot
KNOWN = Pool("known", 8)  # people who wait in a queue, or are staff
EVERYBODY = Pool("everybody", 2)  # the part of snapshots that is read once for all who watch a robot
ANYBODY = Pool("anybody", 4)
