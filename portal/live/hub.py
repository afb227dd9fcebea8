"""One subscription per stream and process; every viewer gets the same bytes, and only the newest.

Pictures never go through a channel layer. A slow viewer skips pictures and states; a viewer that missed an event is
told to read everything again.
"""

import asyncio
import contextlib
import logging
from collections import deque
from typing import Any

import msgspec
import redis.asyncio as aioredis
from django.conf import settings
from redis.exceptions import RedisError

from portal.live.messages import CAMERAS
from portal.live.sessions import session_watch
from portal.live.streams import Streams
from robots import bus
from robots.contract.streams import MOST
from robots.messages import Event, decode

log = logging.getLogger(__name__)
PING_S = 2.0
EVENTS = 100
CHANNELS = (bus.events_channel, bus.state_channel, bus.stream_channel, bus.trace_channel)


class Viewer:
    """One socket's mailbox: each camera's newest picture, the newest state, a few events."""

    def __init__(self, slug: str) -> None:
        self.slug = slug
        self.trace = False
        self.link = True
        self.cameras = frozenset({0})  # the cameras that it wants
        self.frames: dict[int, bytes] = {}
        self.state: bytes | None = None
        self.told: dict[int, tuple[list[bytes], int]] = {}  # of each byte stream: which key packet's, how many
        self.events: deque[Event] = deque()
        self.resync = False
        self.wake = asyncio.Event()

    def put_event(self, event: Event) -> None:
        """Queue an event; if the queue is full, ask for a new snapshot instead."""
        if len(self.events) >= EVENTS:
            self.events.clear()
            self.resync = True
        self.events.append(event)
        self.wake.set()


class Hub:
    """The hub of one event loop."""

    def __init__(self) -> None:
        self._rooms: dict[str, set[Viewer]] = {}
        self._newest: dict[str, dict[int, bytes]] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._redis: aioredis.Redis | None = None
        self._pubsub: Any = None
        self._subscribing = asyncio.Lock()
        self._restoring: set[str] = set()
        self.streams = Streams()
        self.link = False

    def attach(self, viewer: Viewer) -> None:
        """Add a viewer; the first one starts the reader."""
        self._rooms.setdefault(viewer.slug, set()).add(viewer)
        self._give_newest(viewer)
        viewer.wake.set()  # for the byte streams
        if not self._tasks:
            self._hold(self._read())
            self._hold(self._keep_watch())
        else:
            self._hold(self._follow(viewer.slug))

    def choose(self, viewer: Viewer, cameras: frozenset[int]) -> None:
        """Send the viewer the pictures of these cameras from now on, the newest of each at once."""
        viewer.cameras = cameras
        self._give_newest(viewer)
        if self.link:
            self._hold(self._mark_watched(viewer.slug))

    def _give_newest(self, viewer: Viewer) -> None:
        for camera, data in self._newest.get(viewer.slug, {}).items():
            if camera in viewer.cameras:
                viewer.frames[camera] = data
                viewer.wake.set()

    def _hold(self, coroutine: Any) -> None:
        task = asyncio.create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def detach(self, viewer: Viewer) -> None:
        """Remove a viewer."""
        room = self._rooms.get(viewer.slug, set())
        room.discard(viewer)
        if not room:
            self._rooms.pop(viewer.slug, None)
            self._newest.pop(viewer.slug, None)
            self.streams.forget(viewer.slug)
            self._hold(self._follow(viewer.slug))

    def viewers(self, slug: str) -> int:
        """Return the number of viewers of the robot in this process."""
        return len(self._rooms.get(slug, ()))

    def _channels(self, slug: str) -> list[str]:
        frames = [bus.frames_channel(slug, camera) for camera in range(CAMERAS)]
        return [*frames, *(f(slug) for f in CHANNELS)]

    async def _follow(self, slug: str) -> None:
        """Subscribe to a robot while it has viewers."""
        with contextlib.suppress(RedisError, OSError):
            async with self._subscribing:  # the last caller sees the present state
                if self._pubsub is None:
                    return
                if slug not in self._rooms:
                    await self._pubsub.unsubscribe(*self._channels(slug))
                    return
                await self._pubsub.subscribe(*self._channels(slug))
            await self._mark_watched(slug)
            if not self.streams.knows(slug):
                await self._restore(slug)

    async def _restore(self, slug: str) -> None:
        """Read what is kept of a robot's byte streams, where its beginning was not heard."""
        if slug in self._restoring or self._redis is None:
            return
        self._restoring.add(slug)
        try:
            kept = self._redis.pipeline(transaction=False)
            for stream in range(MOST):
                kept.lrange(bus.stream_key(slug, stream), 0, -1)
            with contextlib.suppress(RedisError, OSError, ValueError):
                self.streams.restore(slug, await kept.execute())
        finally:
            self._restoring.discard(slug)
        if slug not in self._rooms:
            self.streams.forget(slug)
        self._wake(slug)

    def _wake(self, slug: str) -> None:
        for viewer in self._rooms.get(slug, ()):
            viewer.wake.set()

    async def _read(self) -> None:
        while True:
            try:
                await self._read_once()
            except (RedisError, OSError, ValueError) as error:
                log.debug("hub: %s", error)
            self._set_link(False)
            await asyncio.sleep(0.3)

    async def _read_once(self) -> None:
        connection = aioredis.Redis.from_url(
            settings.REDIS_URL, socket_timeout=None, socket_connect_timeout=0.5, retry=None
        )
        try:
            pubsub = connection.pubsub(ignore_subscribe_messages=True)
            await pubsub.subscribe(bus.sessions_channel())
            # not before it is open: who asks while it opens would open a second one, which nobody reads
            self._redis, self._pubsub = connection, pubsub
            for slug in list(self._rooms):
                self.streams.forget(slug)  # packets were missed
                await self._follow(slug)
            self._set_link(True)
            while True:
                message = await pubsub.get_message(timeout=30.0)
                if message is not None:
                    self._route(message["channel"].decode(), message["data"])
        finally:  # whoever asks from now on must not open the old connection again
            self._redis = self._pubsub = None
            await connection.aclose()

    def _set_link(self, up: bool) -> None:
        if up != self.link:
            self.link = up
            for room in self._rooms.values():
                for viewer in room:
                    viewer.resync = True
                    viewer.wake.set()

    def _route(self, channel: str, data: bytes) -> None:
        if channel == bus.sessions_channel():
            if data.isdigit():
                session_watch().check_soon(int(data))
            return
        _, slug, what = channel.split(":", 2)
        room = self._rooms.get(slug)
        if not room:
            return
        if what.startswith("frames"):
            self._give_picture(slug, room, int(what.removeprefix("frames") or 0), data)
        elif what == "stream":
            if not self.streams.take(slug, data):
                self._hold(self._restore(slug))
            self._wake(slug)
        elif what == "state":
            for viewer in room:
                viewer.state = data
            self._wake(slug)
        else:
            try:
                event = decode(data)
            except msgspec.MsgspecError as error:
                log.warning("an event on the bus was not understood: %s", error)
                return
            for viewer in room:
                if what != "trace" or viewer.trace:
                    viewer.put_event(event)

    def _give_picture(self, slug: str, room: set[Viewer], camera: int, data: bytes) -> None:
        self._newest.setdefault(slug, {})[camera] = data
        for viewer in room:
            if camera in viewer.cameras:
                viewer.frames[camera] = data
                viewer.wake.set()

    async def _keep_watch(self) -> None:
        while True:
            await asyncio.sleep(PING_S)
            await self._mark(bus.web_key())
            for slug in list(self._rooms):
                await self._mark_watched(slug)

    async def _mark_watched(self, slug: str) -> None:
        room = self._rooms.get(slug, set())
        what = [bus.frames_of(camera) for camera in frozenset().union(*(v.cameras for v in room))]
        for one in what + ["trace"] * any(v.trace for v in room) + ["state"] * bool(room):
            await self._mark(bus.watch_key(slug, one))

    async def _mark(self, key: str) -> None:
        if self._redis is None:
            return
        with contextlib.suppress(RedisError, OSError):
            await self._redis.set(key, 1, ex=bus.WATCH_S)


_hubs: dict[int, Hub] = {}


def hub() -> Hub:
    """Return the hub of the running event loop."""
    return _hubs.setdefault(id(asyncio.get_running_loop()), Hub())
