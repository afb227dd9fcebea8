"""Viewers who come and go while the hub's connection opens."""

import asyncio
import contextlib
import random

import pytest

from portal.live.hub import Hub
from portal.live.rooms import Viewer

STEPS = (0, 0, 1, 2, 3, 5, 8, 13, 20, 40)  # of the event loop, between two of them


async def come_and_go(chance):
    """Let viewers come and go in any order until nobody is left; return the channels that the hub listens to then."""
    hub, here = Hub(), []
    for _ in range(chance.randint(1, 12)):
        if here and chance.random() < 0.5:
            hub.detach(here.pop(chance.randrange(len(here))))
        else:
            here.append(Viewer("mercury"))
            hub.attach(here[-1])
        for _ in range(chance.choice(STEPS)):
            await asyncio.sleep(0)
    for viewer in here:
        hub.detach(viewer)
    async with asyncio.timeout(10):
        while not hub.link:
            await asyncio.sleep(0.01)
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(2):
            while len(hub._pubsub.channels) > 1:
                await asyncio.sleep(0.01)
    left = set(hub._pubsub.channels)
    for task in list(hub._tasks):
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task
    return left


@pytest.mark.parametrize("first", range(0, 100, 25))
def test_who_comes_and_goes_while_the_connection_opens_leaves_nothing(redis_server, first):
    for seed in range(first, first + 25):
        left = asyncio.run(come_and_go(random.Random(seed)))
        assert len(left) == 1, f"seed {seed}: {left}"  # what is told of sessions
