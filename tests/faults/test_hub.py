"""Viewers who come and go while the hub's connection opens, and what the hub hears for those who are there."""

import asyncio
import contextlib
import json
import random
import time
from urllib.parse import quote

import pytest

from portal.live.hub import MARK_S
from portal.live.loop import LoopState
from portal.live.viewer import Viewer, Wish
from robots import bus
from robots.kit.packets import Changed, picture_packet
from robots.models import Robot
from tests.conftest import wait_for
from tests.faults.here import heard, line

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

STEPS = (0, 0, 1, 2, 3, 5, 8, 13, 20, 40)  # of the event loop, between two of them


async def ended(hub):
    """End the tasks of a hub."""
    for task in list(hub._tasks):
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task


async def come_and_go(chance):
    """Let viewers come and go in any order until nobody is left; return the channels that the hub listens to then."""
    hub, here = LoopState().hub, []
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
        async with asyncio.timeout(20):
            while len(hub._reader.pubsub.channels) > 1:
                await asyncio.sleep(0.01)
    left = set(hub._reader.pubsub.channels)
    await ended(hub)
    return left


@pytest.mark.parametrize("first", range(0, 100, 25))
def test_who_comes_and_goes_while_the_connection_opens_leaves_nothing(redis_server, first):
    for seed in range(first, first + 25):
        left = asyncio.run(come_and_go(random.Random(seed)))
        assert len(left) == 1, f"seed {seed}: {left}"  # what is told of sessions


def test_a_wish_while_the_connection_opens_is_followed(redis_server):
    """After the channels of its robot were asked for, before Redis has answered all."""

    async def wish():
        hub, one = LoopState().hub, Viewer("mercury")
        hub.attach(one)
        async with asyncio.timeout(10):
            while not hub._listened.get("mercury"):
                await asyncio.sleep(0)
            assert not hub.link
            hub.choose(one, Wish(frozenset({1})))
            while not hub.link:
                await asyncio.sleep(0.005)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(MARK_S / 2):
                    while bus.channel_of("mercury", "frames1").encode() not in hub._reader.pubsub.channels:
                        await asyncio.sleep(0.005)
        found = set(hub._reader.pubsub.channels)
        await ended(hub)
        return found

    assert bus.channel_of("mercury", "frames1").encode() in asyncio.run(wish())


def told(web):
    """Return the channels that the web process has asked Redis for, and what Redis is told is watched."""

    def listened():
        from portal.live.loop import of_loop

        return {name.removeprefix("farhand:mercury:") for name in of_loop().hub._listened.get("mercury", ())}

    prefix = bus.watch_key("mercury", "").encode()
    return web.ask(listened), {key.removeprefix(prefix).decode() for key in bus.connection().keys(prefix + b"*")}


ALWAYS = {"events", "state", "stream", "path"}


def test_a_page_has_what_it_wants_heard_and_of_cameras_that_the_robot_has(web):
    everything = json.dumps({"t": "watch", "cameras": list(range(8))})
    with line(web, path=f"/ws/robots/mercury/?watch={quote(everything)}") as one, line(web) as other:
        heard(one, "snapshot")
        heard(other, "snapshot")
        wait_for(lambda: told(web) == (ALWAYS | {"frames"}, {"frames", "state"}), 5, "one camera")
        one.send(json.dumps({"t": "watch", "cameras": [0, 3], "video": "vp9", "compact": True}))
        wait_for(lambda: told(web)[0] == ALWAYS | {"frames", "video", "compact"}, 2, "what is new, at once")
        other.close()
        wait_for(lambda: told(web)[0] == ALWAYS | {"video", "compact"}, 6, "nothing that nobody wants any more")
        bus.publish_compact("mercury", b"\x80 state")
        assert wait_for(lambda: one.recv(timeout=5) == b"\x80 state", 5, "the state")
        one.send(json.dumps({"t": "watch", "cameras": [0]}))
        wait_for(lambda: "frames" in told(web)[0], 2, "pictures again")
        bus.publish_picture("mercury", picture_packet(1, 1, 0, (), b"jpeg"))
        wait_for(lambda: isinstance(data := one.recv(timeout=5), bytes) and data[0] == 2, 5, "the picture")
    web.nothing_left()
    assert told(web)[0] == set()


def test_what_one_process_could_not_send_is_made_up_though_it_sends_nothing_more(web, robot, owned, monkeypatch):
    """A single message is lost; the connections through which pages hear of changes stay up."""
    with line(web) as one:
        while not heard(one, "snapshot")["link"]:
            pass
        with monkeypatch.context() as away:
            away.setattr(bus.publishing, "reach", lambda *_: -1)
            Robot.objects.update(name="Mercury the Second")
            assert not bus.publish("mercury", Changed("robot"))
        while heard(one, "snapshot", 30)["robot"]["name"] != "Mercury the Second":
            pass
    web.nothing_left()


def test_whoever_wishes_again_and_again_is_not_given_the_newest_picture_again_and_again(web, robot, owned):
    with line(web) as one:
        while not heard(one, "snapshot")["link"]:
            pass
        bus.publish_picture("mercury", picture_packet(7, 1, 0, (), b"jpeg"))
        wait_for(lambda: web.left()["pictures"], 5, "the picture, before the wishes")
        begun, pictures, answered = time.monotonic(), 0, False
        for n in range(30):
            one.send(json.dumps({"t": "watch", "cameras": [0], "every_s": 15 if n % 2 else 0}))
        one.send(json.dumps({"t": "ping", "n": 5}))
        while not answered:
            data = one.recv(timeout=20)
            pictures += isinstance(data, bytes) and data[0] == 2
            answered = isinstance(data, str) and json.loads(data)["t"] == "pong"
        assert 1 <= pictures <= 3 + time.monotonic() - begun
    web.nothing_left()
