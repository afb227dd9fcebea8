"""Threads beside the event loop, in pools that strangers cannot fill for others.

Who stands in a queue or may move a robot has threads of their own, and of them one person
has at most `EACH` at a time; so what a stranger asks for never delays a command, a stop or a
heartbeat. What needs Redis alone and must not wait (stop, keep-alives) has a third pool.
"""

import asyncio
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

from channels.db import database_sync_to_async

P = ParamSpec("P")
R = TypeVar("R")
EACH = 3


class Pool:
    """Some threads for one sort of work; of those, each person (by id) uses at most `EACH` at a time."""

    def __init__(self, name: str, threads: int) -> None:
        self._executor = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._people: dict[tuple[int, int], tuple[asyncio.Semaphore, int]] = {}

    def orm(self, function: Callable[P, R], person: int = 0) -> Callable[P, Coroutine[Any, Any, R]]:
        """Return `function` as a coroutine function that runs in a thread with a database connection."""
        made: Callable[P, Coroutine[Any, Any, R]] = database_sync_to_async(
            function, thread_sensitive=False, executor=self._executor
        )

        async def run(*args: P.args, **kwargs: P.kwargs) -> R:
            if not person:
                return await made(*args, **kwargs)
            key = (id(asyncio.get_running_loop()), person)
            room, users = self._people.get(key) or (asyncio.Semaphore(EACH), 0)
            self._people[key] = (room, users + 1)
            try:
                async with room:
                    return await made(*args, **kwargs)
            finally:
                users = self._people[key][1] - 1
                if users:
                    self._people[key] = (room, users)
                else:
                    del self._people[key]

        return run

    async def run(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Run in a thread what needs no database."""
        return await asyncio.get_running_loop().run_in_executor(self._executor, lambda: function(*args, **kwargs))


URGENT = Pool("urgent", 4)  # stop and keep-alives of who may send them
KNOWN = Pool("known", 8)  # who operates, waits in a queue, or is staff
ANYBODY = Pool("anybody", 4)
