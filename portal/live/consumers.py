"""The robot's socket: frames, states and events out; commands, stop and presence in.

What must not wait for the database does not: a stop and the keep-alives of a held motion go
to the bus at once, from what this socket was told last. Everything else is asked in order.
"""

import asyncio
import contextlib
import json
import time
from typing import Any

import msgspec
from channels.generic.websocket import AsyncWebsocketConsumer
from django.db import Error

from portal.live.actions import Answer, act, plan
from portal.live.hub import CAMERAS, Viewer, hub
from portal.live.people import current_user
from portal.live.snapshot import snapshot
from portal.live.threads import orm
from portal.stores import down_text
from queueing import services as queue
from robots import bus
from robots.clock import SYSTEM
from robots.messages import Changed
from robots.models import Robot

RATE, BURST = 30.0, 60.0
RESYNC_S = 1.0
AGAIN_S = 2.0  # between two looks at a database that is away
PLAN_S = 0.05  # between two previews of one page
NOT_FOUND, TOO_FAST, BAD_MESSAGE = 4404, 4429, 4400
LONGEST = 8192
WAITING = 64


class RobotConsumer(AsyncWebsocketConsumer):  # type: ignore[misc]
    """One viewer of one robot; whoever holds the grant may also command it."""

    async def connect(self) -> None:
        """Accept, send the snapshot, begin to forward."""
        self.slug = self.scope["url_route"]["kwargs"]["slug"]
        self.viewer = Viewer(self.slug)
        self._tokens, self._filled = BURST, time.monotonic()
        self._asked: asyncio.Queue[dict[str, Any]] = asyncio.Queue(WAITING)
        self._stale = asyncio.Event()
        self._plan: dict[str, Any] | None = None
        self._planning = asyncio.Event()
        self._tasks: list[asyncio.Task[None]] = []
        self._me, self._may_stop, self._jog = 0, False, 0
        self._held: frozenset[str] | None = None
        await self.accept()
        try:
            self._held = await orm(self._held_kinds)()
        except Robot.DoesNotExist:
            await self.close(NOT_FOUND)
            return
        except Error as error:
            await self._store_down(error)
        hub().attach(self.viewer)
        self._asked.put_nowait({"t": "ping"})
        await self._send_snapshot()
        self._tasks = [
            asyncio.create_task(loop()) for loop in (self._forward, self._serve, self._resync, self._preview)
        ]

    def _held_kinds(self) -> frozenset[str]:
        return frozenset(c.kind for c in Robot.objects.get(slug=self.slug).features().commands if c.held)

    def _is_held(self, kind: Any) -> bool:
        """Tell whether a command lives from keep-alives; while the database has not said, any may."""
        return self._held is None or kind in self._held

    async def disconnect(self, code: int) -> None:
        """Forget the viewer; the operator's turn is kept for a while."""
        hub().detach(self.viewer)
        for task in self._tasks:
            task.cancel()
        if self._jog:
            await self._keep(self._jog, held=False)
        with contextlib.suppress(Exception):
            await orm(self._left)()

    def _left(self) -> None:
        user = current_user(self.scope)
        if user.is_authenticated:
            queue.disconnected(Robot.objects.get(slug=self.slug), user, SYSTEM.now())

    def _mark_seen(self) -> None:
        user = current_user(self.scope)
        if user.is_authenticated:
            queue.seen(Robot.objects.get(slug=self.slug), user, SYSTEM.now(), classic=False)

    async def receive(self, text_data: str | None = None, bytes_data: bytes | None = None) -> None:
        """Take one message; too many or malformed ones close the socket with a code."""
        now = time.monotonic()
        self._tokens = min(BURST, self._tokens + (now - self._filled) * RATE) - 1
        self._filled = now
        if self._tokens < 0:
            await self.close(TOO_FAST)
            return
        try:
            message = json.loads(text_data or "")
            if not isinstance(message, dict) or len(text_data or "") > LONGEST:
                raise ValueError
        except (ValueError, RecursionError):
            await self.close(BAD_MESSAGE)
            return
        await self._take(message)

    async def _take(self, message: dict[str, Any]) -> None:
        """Do at once what may not wait; queue the rest."""
        kind, seq = message.get("t"), message.get("seq")
        message.pop("rung", None)
        if kind == "ping":
            at_ms = int(SYSTEM.now().timestamp() * 1000)
            await self.send(json.dumps({"t": "pong", "n": message.get("n"), "now_ms": at_ms, "link": hub().link}))
        elif kind == "stop" and self._may_stop:
            message["rung"] = await asyncio.to_thread(bus.ring_stop, self.slug)
        elif kind == "plan":
            self._plan = message  # the newest only: a slider asks faster than arms are planned
            self._planning.set()
            return
        elif kind == "watch":
            self._watch(message.get("cameras"))
            return
        elif kind in ("keep", "let_go"):
            if isinstance(seq, int) and seq == self._jog:
                await self._keep(seq, held=kind == "keep")
            return
        elif kind == "command" and self._is_held(message.get("kind")) and isinstance(seq, int) and 0 < seq < 2**53:
            self._jog = seq
        try:
            self._asked.put_nowait(message)
        except asyncio.QueueFull:
            if kind != "ping":
                await self._answer(message, Answer(False, "The database is too slow now; nothing was done.", "busy"))

    def _watch(self, cameras: Any) -> None:
        """Follow the cameras the page shows; what is no list of cameras changes nothing."""
        if isinstance(cameras, list) and all(isinstance(c, int) and 0 <= c < CAMERAS for c in cameras):
            hub().choose(self.viewer, frozenset(cameras))

    async def _keep(self, seq: int, held: bool) -> None:
        await asyncio.to_thread(bus.keep, self.slug, self._me, seq, held)
        if not held:
            self._jog = 0

    async def _serve(self) -> None:
        """Carry out what was asked, in order."""
        while True:
            message = await self._asked.get()
            if message.get("t") == "ping":
                with contextlib.suppress(Exception):  # presence is told again with the next ping
                    await orm(self._mark_seen)()
                continue
            try:
                answer = await orm(act)(self.scope, self.slug, message)
            except Error as error:
                answer = Answer(False, down_text(error), "store_down")
            await self._answer(message, answer)

    async def _preview(self) -> None:
        """Say where the newest target that was asked about would lead."""
        while True:
            await self._planning.wait()
            self._planning.clear()
            message, self._plan = self._plan, None
            if message is None:
                continue
            try:
                found = await orm(plan)(self.scope, self.slug, message)
            except Error as error:
                found = {"ok": False, "text": down_text(error)}
            await self.send(json.dumps({"t": "plan", "n": message.get("n"), **found}))
            await asyncio.sleep(PLAN_S)

    async def _answer(self, message: dict[str, Any], answer: Answer) -> None:
        if answer.trace is not None:
            self.viewer.trace = answer.trace
        shown = {"t": "answer", "to": message.get("t"), "seq": message.get("seq"), **answer.fields()}
        await self.send(json.dumps(shown))
        if answer.changed:
            await self._send_snapshot()

    async def _send_snapshot(self) -> None:
        try:
            shown = await orm(self._snapshot)()
        except Error as error:
            await self._store_down(error)
            return
        except Robot.DoesNotExist:
            await self.close(NOT_FOUND)
            return
        await self.send(json.dumps(shown))

    async def send(self, text_data: str | None = None, bytes_data: bytes | None = None, close: bool = False) -> None:
        """Send; a line that ends in the middle of a packet is no error, `disconnect` follows."""
        with contextlib.suppress(OSError):
            await super().send(text_data, bytes_data, close)

    async def _store_down(self, error: Exception) -> None:
        """Say that the database is away, and look again soon."""
        await self.send(json.dumps({"t": "store", "text": down_text(error)}))
        asyncio.get_running_loop().call_later(AGAIN_S, self._look_again)

    def _look_again(self) -> None:
        self.viewer.resync = True
        self.viewer.wake.set()

    def _snapshot(self) -> dict[str, Any]:
        user = current_user(self.scope)
        shown = snapshot(self.slug, user, SYSTEM.now(), self.viewer.link)
        self._me, self._may_stop = user.pk or 0, bool(shown["me"]["may_stop"])
        return shown

    async def _forward(self) -> None:
        """Send what the hub brings; without the link, read the database every second."""
        viewer = self.viewer
        while True:
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(viewer.wake.wait(), RESYNC_S if not hub().link else 15.0)
            viewer.wake.clear()
            viewer.link = hub().link
            if viewer.state is not None:
                state, viewer.state = viewer.state, None
                await self.send(bytes_data=state)
            resync = viewer.resync or not viewer.link
            viewer.resync = False
            while viewer.events:
                event = viewer.events.popleft()
                if isinstance(event, Changed):
                    resync = True
                else:
                    await self.send(msgspec.json.encode(event).decode())
            while viewer.frames:
                _, frame = viewer.frames.popitem()
                await self.send(bytes_data=frame)
            if resync:
                self._stale.set()

    async def _resync(self) -> None:
        """Read everything again when it is stale; pictures and states do not wait for it."""
        while True:
            await self._stale.wait()
            self._stale.clear()
            await self._send_snapshot()
