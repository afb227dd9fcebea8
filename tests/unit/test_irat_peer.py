"""The send queue of one client of the iRat: the newest of each topic, and no more answers than it reads."""

import asyncio
from types import SimpleNamespace

from simulators.common.faults import FaultBoard
from simulators.irat.peer import MOST_ANSWERS, Subscription
from simulators.irat.server import BURST, SocketPeer


class Line:
    """A connection whose other end does not read until it is let."""

    def __init__(self):
        self.remote_address = ("127.0.0.1", 1)
        self.sent, self.aborted, self.reads = [], False, asyncio.Event()
        self.transport = SimpleNamespace(abort=self._abort)

    def _abort(self):
        self.aborted = True

    async def send(self, frame):
        await self.reads.wait()
        self.sent.append(frame)


async def sent(line, last):
    """Wait until a frame was sent."""
    async with asyncio.timeout(20):
        while last not in line.sent:
            await asyncio.sleep(0)


def run(work):
    async def inner():
        peer = SocketPeer(Line(), FaultBoard())
        writer = asyncio.create_task(peer.write())
        await work(peer)
        writer.cancel()

    asyncio.run(inner())


def test_a_slow_reader_gets_the_newest_of_each_topic():
    async def work(peer):
        for number in range(1000):
            peer.show("/a", f"a{number}")
            peer.show("/b", f"b{number}")
            if number == 0:
                await asyncio.sleep(0)  # the writer takes the first, and waits
        peer.show("/c", "last")
        peer.line.reads.set()
        await sent(peer.line, "last")
        assert peer.line.sent == ["a0", "b999", "a999", "last"]
        assert not peer.line.aborted

    run(work)


def test_answers_come_before_topics_and_in_order():
    async def work(peer):
        peer.show("/a", "topic")
        for number in range(5):
            peer.answer(str(number))
        peer.show("/c", "last")
        peer.line.reads.set()
        await sent(peer.line, "last")
        assert peer.line.sent == [*"01234", "topic", "last"]

    run(work)


def test_who_does_not_read_answers_is_disconnected():
    async def work(peer):
        for number in range(MOST_ANSWERS):
            peer.answer(str(number))
        assert not peer.line.aborted
        peer.answer("one more")
        assert peer.line.aborted

    run(work)


def test_a_faster_sender_waits():
    async def work(peer):
        loop = asyncio.get_running_loop()
        began = loop.time()
        for _ in range(int(BURST) + 100):
            await peer.within_rate()
        assert loop.time() - began >= 0.2

    run(work)


def test_each_message_says_that_its_sender_is_not_silent():
    async def work(peer):
        peer.heard_at = 0.0
        await peer.within_rate()
        assert peer.heard_at > 0.0

    run(work)


def test_each_subscription_has_its_own_pace():
    async def work(peer):
        peer.subscriptions["/a"] = {"slow": Subscription(1.0), "quick": Subscription(0.1)}
        sent = sum(peer.wants("/a", 10 + k * 0.05) for k in range(40))
        assert 19 <= sent <= 22
        del peer.subscriptions["/a"]["quick"]
        assert sum(peer.wants("/a", 20 + k * 0.05) for k in range(40)) == 2

    run(work)
