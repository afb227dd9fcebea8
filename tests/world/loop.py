"""An event loop that runs in a thread of a world: its time is the world's, and its pools are threads of the world."""

import asyncio
import math
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from functools import partial

from tests.world.world import Killed, World


class Selector:
    """Where the loop waits: until a timer is due, something awaited holds, or another thread has woken it."""

    def __init__(self, world: World) -> None:
        self._world = world
        self.awaited: dict[asyncio.Future, Callable[[], object]] = {}
        self.woken, self.over, self.passed_s = False, False, 0.0

    def select(self, timeout: float | None) -> list[asyncio.Future]:
        """Return what is awaited and holds. Fails once it is `over` and nothing can happen any more."""
        world = self._world
        if self.over:
            if timeout is None:
                raise TimeoutError("nothing more happens")
            self.passed_s += timeout
        elif timeout == 0:
            world.yield_()  # as to threads on another core
        else:
            world.park(math.inf if timeout is None else world.monotonic() + timeout, self._comes)
        self.woken = False
        return [future for future, holds in self.awaited.items() if holds()]

    def _comes(self) -> bool:
        return self.woken or any(holds() for holds in self.awaited.values())


class WorldLoop(asyncio.BaseEventLoop):
    """The event loop of one process of a world. It is made, and runs, in a thread of that process."""

    def __init__(self, world: World) -> None:
        super().__init__()
        self._world, self._selector = world, Selector(world)
        self._pools: dict[Executor, Pool] = {}

    def time(self) -> float:
        return self._world.monotonic() + self._selector.passed_s

    def _write_to_self(self) -> None:
        self._selector.woken = True

    def _process_events(self, events: list[asyncio.Future]) -> None:
        for future in events:
            if not future.done():
                future.set_result(None)

    async def until(self, holds: Callable[[], object]) -> None:
        """Wait until something of the world holds, as for a connection from which can be read."""
        while not holds():
            future = self.create_future()
            self._selector.awaited[future] = holds
            try:
                await future
            finally:
                del self._selector.awaited[future]

    def run_in_executor(self, executor: Executor | None, function: Callable, *args) -> asyncio.Future:
        """Run a function in a thread of the world, beside as many others as the pool has threads."""
        assert isinstance(executor, ThreadPoolExecutor), "every pool of the product is its own"
        if self._selector.over:
            raise RuntimeError("cannot schedule new futures after shutdown")
        if executor not in self._pools:
            self._pools[executor] = Pool(self._world, executor)
        return asyncio.wrap_future(self._pools[executor].submit(partial(function, *args)), loop=self)

    def serve(self) -> None:
        """Run until the world closes; then end what runs, which nobody sees any more."""
        try:
            self.run_forever()
        finally:
            self._selector.over = True
            with suppress(Killed, TimeoutError):
                self.run_until_complete(self._end())
            self.close()

    async def _end(self) -> None:
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


class Pool:
    """Threads of the world that do what was given to a pool, in that order; each begins when there is work for it."""

    def __init__(self, world: World, like: ThreadPoolExecutor) -> None:
        self._world, self._process = world, world.running.process
        self._most, self._name = like._max_workers, like._thread_name_prefix
        self._work: deque[tuple[Future, Callable[[], object]]] = deque()
        self._begun = self._idle = 0

    def submit(self, work: Callable[[], object]) -> Future:
        future: Future = Future()
        self._work.append((future, work))
        if self._idle < len(self._work) and self._begun < self._most:
            self._begun += 1
            self._world.spawn(self._run, f"{self._name} {self._begun}", self._process)
        return future

    def _run(self) -> None:
        while True:
            self._idle += 1
            self._world.park(math.inf, lambda: self._work)
            self._idle -= 1
            future, work = self._work.popleft()
            if future.set_running_or_notify_cancel():
                try:
                    future.set_result(work())
                except Killed:
                    raise
                except BaseException as error:
                    future.set_exception(error)
