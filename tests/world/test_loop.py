"""The event loop of a world: virtual time, work in threads of the world, and its end."""

import asyncio
import threading
from math import inf

import pytest

from portal.live.threads import Pool
from tests.world.loop import WorldLoop
from tests.world.world import World


@pytest.fixture
def opened():
    made = []

    def begin(seed=1):
        made.append(World(seed))
        return made[-1]

    yield begin
    for world in made:
        if not world.closed:
            world.close()


class Served:
    """A loop that serves in a process of its own."""

    def __init__(self, world):
        self.world, self.loop, self.found = world, None, []
        self.process = world.process("web")
        world.spawn(self._run, "loop", self.process)
        world.until(lambda: self.loop, 1, "the loop")

    def _run(self):
        self.loop = WorldLoop(self.world)
        self.loop.serve()

    def ask(self, coroutine):
        """Return what a coroutine returns in the loop; other threads of the world run meanwhile."""
        future = asyncio.run_coroutine_threadsafe(coroutine, self.loop)
        self.world.park(inf, future.done)
        return future.result()


def test_a_day_takes_no_time(opened):
    served = Served(opened())

    async def sleeps():
        begun = asyncio.get_running_loop().time()
        await asyncio.sleep(86400)
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(60):
                await asyncio.Event().wait()
        return asyncio.get_running_loop().time() - begun

    assert served.ask(sleeps()) == pytest.approx(86460)


def test_another_thread_wakes_it(opened):
    served, come = Served(world := opened()), []
    world.spawn(lambda: (world.sleep(5), come.append(world.monotonic())), "other")

    async def waits():
        await served.loop.until(lambda: come)
        return world.monotonic()

    assert served.ask(waits()) == come[0]


def test_work_of_a_pool_runs_in_so_many_threads_of_the_world(opened):
    served, pool = Served(world := opened()), Pool("two", 2)
    at_once, most = [], []

    def work(number):
        at_once.append(number)
        most.append(len(at_once))
        world.sleep(1.0)
        at_once.remove(number)
        return number, threading.current_thread() in world.threads

    async def all_of_it():
        return await asyncio.gather(*(pool.run(work, number) for number in range(6)))

    begun = world.monotonic()
    assert served.ask(all_of_it()) == [(number, True) for number in range(6)]
    assert max(most) == 2
    assert world.monotonic() - begun == pytest.approx(3.0, abs=0.1)

    def fails():
        raise ValueError("work")

    with pytest.raises(ValueError, match="work"):
        served.ask(pool.run(fails))


def test_work_that_nobody_awaits_any_more_does_not_begin(opened):
    served, pool, done = Served(world := opened()), Pool("one", 1), []

    async def cancelled():
        first = asyncio.ensure_future(pool.run(world.sleep, 1.0))
        second = asyncio.ensure_future(pool.run(done.append, 1))
        await asyncio.sleep(0.5)
        second.cancel()
        await first
        await pool.run(world.sleep, 0.1)

    served.ask(cancelled())
    assert not done


def test_who_runs_between_two_steps_of_the_loop_is_chosen_by_the_seed(opened):
    def run(seed):
        served, pool, seen = Served(world := opened(seed)), Pool("many", 4), []

        async def steps(name):
            for number in range(4):
                seen.append((name, number))
                await asyncio.sleep(0)
                await pool.run(seen.append, number)

        async def both():
            await asyncio.gather(steps("a"), steps("b"))

        served.ask(both())
        history = world.history
        world.close()
        return seen, history

    runs = [run(seed) for seed in (1, 1, 2, 3, 4)]
    assert runs[0] == runs[1]
    assert len({str(seen) for seen, _ in runs}) > 1


def test_what_runs_when_the_world_closes_ends_with_it(opened):
    served, pool, ended = Served(world := opened()), Pool("late", 1), []

    async def stays():
        try:
            await asyncio.sleep(1000)
        finally:
            await asyncio.sleep(5)
            with pytest.raises(RuntimeError):
                await pool.run(ended.append, "work")
            ended.append("cleared")

    served.loop.call_soon_threadsafe(lambda: ended.append(served.loop.create_task(stays())))
    world.sleep(1)
    before = world.monotonic()
    world.close()
    assert ended[1:] == ["cleared"]
    assert served.loop.is_closed()
    assert world.monotonic() == before


def test_a_killed_process_does_nothing_more(opened):
    served, done = Served(world := opened()), []

    async def ticks():
        while True:
            await asyncio.sleep(1)
            done.append(1)

    served.loop.call_soon_threadsafe(lambda: done.append(served.loop.create_task(ticks())))
    world.sleep(3.5)
    world.kill(served.process)
    number = len(done)
    world.sleep(10)
    assert len(done) == number == 4
