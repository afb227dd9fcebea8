"""One subscription per stream and process; every viewer gets the same bytes, and only the newest.

Pictures never go through a channel layer. Each message is written at once to each viewer whose connection has taken
everything before it: no copy, task or queue for a viewer. For the others it waits in their mailbox: a slow viewer skips
pictures and states; a viewer that missed an event is sent a new snapshot.
"""

import asyncio
import contextlib
import logging
import secrets
from collections import Counter
from collections.abc import Iterator
from string import digits
from typing import Any

import msgspec
from redis.exceptions import RedisError

from portal.live.audience import Audience
from portal.live.cheers import KEPT_S, Cheers
from portal.live.rooms import Room
from portal.live.sessions import SessionWatch
from portal.live.store import Reader
from portal.live.streams import Streams
from portal.live.threads import URGENT
from portal.live.viewer import Cameras, Viewer, Wish
from portal.live.watchers import COUNT_S, read_watchers, together
from robots import bus
from robots.bus.reader import SILENT_S
from robots.kit.contract.streams import MOST
from robots.kit.packets import decode

log = logging.getLogger(__name__)
MARK_S = 2.0  # between two marks of the demand in Redis, each of which is valid for `bus.WATCH_S`
HEARD_S = 1.0  # the longest wait of a new viewer for the subscription


class Hub:
    """The hub of one event loop."""

    def __init__(self, audience: Audience, sessions: SessionWatch) -> None:
        self._audience, self._sessions = audience, sessions
        self._rooms: dict[str, Room] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._reader = Reader(bus.sessions_channel(), self._take, self._lose, self._follow_all)
        self._subscribing = asyncio.Lock()
        self._restoring: set[str] = set()
        self._listened: dict[str, set[str]] = {}  # channels that Redis was asked for, by robot
        self._awaited = Counter[str]()  # subscriptions that Redis has not confirmed yet, by robot
        self._name = secrets.token_hex(6)  # of this hub among all
        self._away = False  # the last attempt to reach Redis failed
        self.streams = Streams()
        self.link = False

    def attach(self, viewer: Viewer, cameras: Cameras | None = None, wish: Wish | None = None) -> None:
        """Add a viewer; the first one starts the reader.

        `cameras`: those of the robot, if that was read. `wish`: what the viewer wants, if it has said so.
        """
        room = self._rooms.setdefault(viewer.slug, Room(viewer.slug, self._audience))
        room.cameras = room.cameras if cameras is None else cameras
        viewer.choose((wish or viewer.wish).within(room.cameras))
        known = room.watched()
        room.add(viewer)
        room.give_newest(viewer)
        room.give_running_path(viewer)
        viewer.wake()  # for the byte streams
        if not self._tasks:
            self._hold(self._reader.run())
            self._hold(self._keep_watch())
        elif not room.confirmation.is_set() or room.watched() != known:
            self._hold(self._follow(viewer.slug))

    async def wait_until_subscribed(self, slug: str, within_s: float | None = HEARD_S) -> bool:
        """Wait until a robot's events are subscribed; not while Redis is away. Return False if that took longer."""
        room = self._rooms.get(slug)
        if room is None or self._away:
            return True
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(within_s):
                return await room.confirmation.wait()
        return False

    def choose(self, viewer: Viewer, wish: Wish) -> None:
        """Change the viewer's wish, and send it the newest picture of each camera at once."""
        room = self._rooms.get(viewer.slug)
        if room is None:
            return
        known = self._needed(viewer.slug)
        with self._changing(viewer):
            viewer.choose(wish.within(room.cameras))
        room.give_newest(viewer)
        viewer.wake()
        if not self._needed(viewer.slug) <= known:
            self._hold(self._follow(viewer.slug))

    def _needed(self, slug: str) -> set[str]:
        room = self._rooms.get(slug)
        return {*room.watched(), *room.keys()} if room is not None else set()

    def count_as(self, viewer: Viewer, visitor: int) -> None:
        """Count the viewer as a page of this person; an operator as nobody (0)."""
        if viewer.visitor != visitor:
            with self._changing(viewer):
                viewer.visitor = visitor

    async def trace(self, viewer: Viewer, on: bool) -> None:
        """Send the viewer the wire trace from now on, or no more."""
        with self._changing(viewer):
            viewer.trace = on
        if on:
            await self._follow(viewer.slug)

    @contextlib.contextmanager
    def _changing(self, viewer: Viewer) -> Iterator[None]:
        """Change a viewer's wish or visitor during the body of a `with` statement; its groups and counts follow."""
        room = self._rooms.get(viewer.slug)
        here = room is not None and viewer in room.viewers
        if room is not None and here:
            room.remove(viewer)
        try:
            yield
        finally:
            if room is not None and here:
                room.add(viewer)

    def news(self, viewer: Viewer) -> list[bytes]:
        """Return the packets of byte streams that a viewer does not have yet, and note that it has them now."""
        return self.streams.news(viewer.slug, viewer.stream_cursors)

    def video(self, viewer: Viewer) -> list[bytes]:
        """Return the packets of video that a viewer does not have yet, and note that it has them now."""
        room = self._rooms.get(viewer.slug)
        return room.take_missing(viewer) if room is not None else []

    def _hold(self, coroutine: Any) -> None:
        task = asyncio.create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def detach(self, viewer: Viewer) -> None:
        """Remove a viewer."""
        room = self._rooms.get(viewer.slug)
        if room is not None:
            room.remove(viewer)
        if room is None or not room.viewers:
            self._rooms.pop(viewer.slug, None)
            self.streams.forget(viewer.slug)
            self._hold(self._follow(viewer.slug))

    def viewers(self, slug: str) -> int:
        """Return the number of viewers of the robot in this process."""
        room = self._rooms.get(slug)
        return len(room.viewers) if room is not None else 0

    def watchers(self, slug: str) -> int:
        """Return how many watch the robot in all web processes, as far as this one knows."""
        room = self._rooms.get(slug)
        return room.watching() if room is not None else 0

    def cheers(self, slug: str) -> Cheers:
        """Return the cheers for who drives the robot; of a robot that nobody watches here none are kept."""
        room = self._rooms.get(slug)
        return room.cheers if room is not None else Cheers()

    def strangers(self, slug: str) -> int:
        """Return how many pages of people who are not signed in watch the robot in this process."""
        room = self._rooms.get(slug)
        return room.strangers if room is not None else 0

    async def _follow(self, slug: str) -> None:
        """Subscribe to the channels that a robot's viewers want, while it has any."""
        with contextlib.suppress(RedisError, OSError):
            async with self._subscribing:  # the last caller sees the present state
                if self._reader.pubsub is None:
                    return
                room = self._rooms.get(slug)
                async with asyncio.timeout(SILENT_S):  # the connection may have ended silently
                    listened = self._listened.setdefault(slug, set())
                    if room is None:
                        del self._listened[slug]
                        if listened:  # none would mean all
                            await self._reader.pubsub.unsubscribe(*listened)
                        return
                    new = room.channels() - listened
                    if not room.requested:  # also where an earlier room has subscribed: the answer confirms it
                        new.add(bus.events_channel(slug))
                        self._awaited[slug] += 1
                        room.requested = True
                    if new:
                        listened |= new
                        await self._reader.pubsub.subscribe(*new)
            await self._mark_watched(slug)
            if not self.streams.knows(slug):
                await self._restore(slug)

    async def _unfollow(self, slug: str) -> None:
        """Unsubscribe from a robot's channels that nobody wants any more."""
        with contextlib.suppress(RedisError, OSError):
            async with self._subscribing:
                room, listened = self._rooms.get(slug), self._listened.get(slug)
                if (
                    self._reader.pubsub is None
                    or room is None
                    or not listened
                    or not (gone := listened - room.channels())
                ):
                    return
                listened -= gone
                for camera in list(room.newest):
                    room.outdate(camera)
                async with asyncio.timeout(SILENT_S):
                    await self._reader.pubsub.unsubscribe(*gone)

    async def _restore(self, slug: str) -> None:
        """Read a robot's byte streams and path from Redis, because their beginning was not received."""
        if slug in self._restoring or self._reader.connection is None:
            return
        self._restoring.add(slug)
        try:
            kept = self._reader.connection.pipeline(transaction=False)
            kept.get(bus.path_key(slug))
            for stream in range(MOST):
                kept.lrange(bus.stream_key(slug, stream), 0, -1)
            with contextlib.suppress(RedisError, OSError, ValueError):
                async with asyncio.timeout(SILENT_S):
                    path, *streams = await kept.execute()
                    self.streams.restore(slug, streams)
                    if path and slug in self._rooms:
                        self._rooms[slug].give_path(path)
        finally:
            self._restoring.discard(slug)
        if slug not in self._rooms:
            self.streams.forget(slug)
        else:
            self._rooms[slug].wake()

    async def _follow_all(self) -> None:
        """Subscribe to the channels of all robots, over a connection that has just been opened."""
        self._awaited.clear()
        self._listened.clear()
        for slug, room in list(self._rooms.items()):
            room.confirmation.clear()
            room.requested = False
            self.streams.forget(slug)  # packets were missed
            await self._follow(slug)

    def _lose(self) -> None:
        self._away = True
        self._set_link(False)

    def _take(self, message: dict[str, Any]) -> None:
        match message["type"]:
            case "message":
                self._route(message["channel"].decode(), message["data"])
            case "subscribe":
                self._confirmed(message["channel"].decode())
            case "pong":
                self._away = False
                self._set_link(True)
                for slug, room in self._rooms.items():
                    if room.requested and not self._awaited[slug]:
                        room.confirmation.set()

    def _confirmed(self, channel: str) -> None:
        """Note that Redis sends everything of this channel from now on."""
        slug = channel.split(":")[1]
        if channel != bus.events_channel(slug):
            return
        self._awaited[slug] -= 1
        if self._awaited[slug] <= 0:
            del self._awaited[slug]
            if self.link and slug in self._rooms:
                self._rooms[slug].confirmation.set()

    def _set_link(self, up: bool) -> None:
        if up != self.link:
            self.link = up
            for room in self._rooms.values():
                for viewer in room.viewers:
                    viewer.ask_snapshot()

    def _route(self, channel: str, data: bytes) -> None:
        if channel == bus.sessions_channel():
            if data.isdigit():
                self._sessions.check_soon(int(data))
            return
        _, slug, what = channel.split(":", 2)
        room = self._rooms.get(slug)
        if room is None:
            return
        kind = what.rstrip(digits)
        if kind in ("frames", "coarse"):
            room.give_picture(int(what.removeprefix(kind) or 0), data, kind == "coarse")
        elif kind in ("video", "coarsevideo"):
            if not room.give_video(int(what.removeprefix(kind) or 0), data, kind == "coarsevideo"):
                self._hold(self._ask_keys(slug))
        elif what == "stream":
            self._give_packet(slug, room, data)
        elif what == bus.SOUND:
            room.give_sound(data)
        elif what == "path":
            room.give_path(data)
        elif what in ("state", "compact"):
            room.give_state(data, what == "compact")
        else:
            try:
                event = decode(data)
            except msgspec.MsgspecError as error:
                log.warning("an event on the bus was not understood: %s", error)
                return
            room.give_event(event, what == "trace")

    def _give_packet(self, slug: str, room: Room, data: bytes) -> None:
        if not self.streams.take(slug, data):
            self._hold(self._restore(slug))
        room.give_packets(lambda viewer: self.streams.news(slug, viewer.stream_cursors))

    async def _keep_watch(self) -> None:
        while True:
            await asyncio.sleep(MARK_S)
            try:
                await self._keep_watch_once()
            except Exception:
                log.exception("the robots that are watched could not be reported")

    async def _keep_watch_once(self) -> None:
        await self._mark(bus.web_key())
        if bus.lost_events() and self.link:
            await URGENT.run(bus.make_up)
        for slug in list(self._rooms):
            await self._unfollow(slug)
            await self._follow(slug)  # also for wishes that came while Redis was away
            await self._count(slug)
            await self._count_cheers(slug)

    async def _count(self, slug: str) -> None:
        """Tell the other web processes how many watch here, and everybody here how many watch in all."""
        room, store = self._rooms.get(slug), self._reader.connection
        if room is None or store is None:
            return
        key = bus.watchers_key(slug)
        with contextlib.suppress(RedisError, OSError):
            now, _ = await store.time()  # of Redis: clocks of hosts differ
            both = store.pipeline(transaction=False)
            both.hset(key, self._name, room.here(now).text())
            both.expire(key, 10 * COUNT_S)
            both.hgetall(key)
            *_, told = await both.execute()
            counts = {name: read_watchers(value) for name, value in told.items()}
            if old := [name for name, one in counts.items() if now - one.at > COUNT_S]:
                await store.hdel(key, *old)
            room.give_count(together(one for name, one in counts.items() if name not in old))

    async def _count_cheers(self, slug: str) -> None:
        """Add the new cheers to those of other processes, and tell everybody here how many there are."""
        room, store = self._rooms.get(slug), self._reader.connection
        if room is None or store is None or not room.cheers.grant:
            return
        grant, new = room.cheers.grant, room.cheers.new
        key = bus.cheers_key(slug, grant)
        with contextlib.suppress(RedisError, OSError):
            both = store.pipeline(transaction=False)
            both.incrby(key, new)
            both.expire(key, KEPT_S)
            count, _ = await both.execute()
            room.give_cheers(grant, new, int(count))

    async def _mark_watched(self, slug: str) -> None:
        room = self._rooms.get(slug)
        if room is None:
            return
        for one in [*room.watched(), "state", *room.keys()]:
            await self._mark(bus.watch_key(slug, one))

    async def _ask_keys(self, slug: str) -> None:
        room = self._rooms.get(slug)
        for one in room.keys() if room is not None else ():
            await self._mark(bus.watch_key(slug, one))

    async def _mark(self, key: str) -> None:
        if self._reader.connection is None:
            return
        with contextlib.suppress(RedisError, OSError):
            await self._reader.connection.set(key, 1, ex=bus.WATCH_S)
