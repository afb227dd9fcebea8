"""On a slow line pictures and snapshots are sent in turns, each as soon as everything before it was taken."""

import asyncio
from types import SimpleNamespace

from portal.live.writer import Writer
from tests.waiting import CEILING_S


class Slow:
    """A connection that takes one message each time it is let."""

    def __init__(self):
        self.taken, self.waits = [], False

    def free(self):
        return not self.waits

    def is_closing(self):
        return False

    def write(self, what):
        assert not self.waits, "something waits already"
        self.taken.append(what)
        self.waits = True


def test_nothing_that_always_has_more_keeps_the_rest_waiting():
    async def run():
        line = Slow()
        writer = Writer(SimpleNamespace(connection=line), None, asyncio.Event(), None)

        async def pictures():
            while True:
                await writer.wait_until_free()
                line.write("picture")

        async def snapshot():
            await writer.wait_until_free()
            line.write("snapshot")

        always = asyncio.create_task(pictures())
        for _ in range(5):
            await asyncio.sleep(0)
        once = asyncio.create_task(snapshot())
        for _ in range(3):
            for _ in range(5):
                await asyncio.sleep(0)
            line.waits = False
            writer.freed.set()
        for _ in range(5):
            await asyncio.sleep(0)
        always.cancel()
        once.cancel()
        return line.taken

    assert "snapshot" in asyncio.run(run())


def test_a_line_that_is_free_costs_no_wait():
    async def run():
        line = Slow()
        writer = Writer(SimpleNamespace(connection=line), None, asyncio.Event(), None)
        await writer.wait_until_free()
        assert not writer._one_by_one.locked()
        line.write("picture")
        waiting = asyncio.create_task(writer.wait_until_free())
        await asyncio.sleep(0)
        assert writer._one_by_one.locked() and not waiting.done()
        line.is_closing = lambda: True  # a waiting message must not wait for ever
        writer.freed.set()
        await asyncio.wait_for(waiting, CEILING_S)

    asyncio.run(run())
