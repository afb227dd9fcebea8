"""The robot's socket: frames, states and events out; commands, stop and presence in."""

import asyncio
import contextlib
import json
import time
from typing import Any

import msgspec
from channels.db import database_sync_to_async
from channels.generic.websocket import AsyncWebsocketConsumer

from portal.live.actions import Answer, act
from portal.live.hub import Viewer, hub
from portal.live.people import current_user
from portal.live.snapshot import snapshot
from queueing import services as queue
from robots.clock import SYSTEM
from robots.messages import Changed
from robots.models import Robot

RATE, BURST = 20.0, 60.0
RESYNC_S = 1.0
NOT_FOUND, TOO_FAST, BAD_MESSAGE = 4404, 4429, 4400
LONGEST = 8192


class RobotConsumer(AsyncWebsocketConsumer):  # type: ignore[misc]
    """One viewer of one robot; whoever holds the grant may also command it."""

    async def connect(self) -> None:
        """Accept, send the snapshot, begin to forward."""
        self.slug = self.scope["url_route"]["kwargs"]["slug"]
        self.viewer = Viewer(self.slug)
        self._tokens, self._filled = BURST, time.monotonic()
        self._sender: asyncio.Task[None] | None = None
        await self.accept()
        if not await database_sync_to_async(Robot.objects.filter(slug=self.slug).exists)():
            await self.close(NOT_FOUND)
            return
        self._note_presence = asyncio.create_task(self._seen())
        hub().attach(self.viewer)
        await self._send_snapshot()
        self._sender = asyncio.create_task(self._forward())

    async def disconnect(self, code: int) -> None:
        """Forget the viewer; the operator's turn is kept for a while."""
        hub().detach(self.viewer)
        if self._sender is not None:
            self._sender.cancel()
        with contextlib.suppress(Exception):
            await database_sync_to_async(self._left)()

    def _left(self) -> None:
        user = current_user(self.scope)
        if user.is_authenticated:
            queue.disconnected(Robot.objects.get(slug=self.slug), user, SYSTEM.now())

    async def _seen(self) -> None:
        await database_sync_to_async(self._mark_seen)()

    def _mark_seen(self) -> None:
        user = current_user(self.scope)
        if user.is_authenticated:
            queue.seen(Robot.objects.get(slug=self.slug), user, SYSTEM.now(), classic=False)

    async def receive(self, text_data: str | None = None, bytes_data: bytes | None = None) -> None:
        """Handle one message; too many or malformed ones close the socket with a code."""
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
        if message.get("t") == "ping":
            await self._pong(message)
            return
        answer = await database_sync_to_async(act)(self.scope, self.slug, message)
        await self._answer(message, answer)

    async def _pong(self, message: dict[str, Any]) -> None:
        at_ms = int(SYSTEM.now().timestamp() * 1000)
        await self.send(json.dumps({"t": "pong", "n": message.get("n"), "now_ms": at_ms, "link": hub().link}))
        await self._seen()

    async def _answer(self, message: dict[str, Any], answer: Answer) -> None:
        if answer.trace is not None:
            self.viewer.trace = answer.trace
        shown = {"t": "answer", "to": message.get("t"), "seq": message.get("seq"), **answer.fields()}
        await self.send(json.dumps(shown))
        if answer.changed:
            await self._send_snapshot()

    async def _send_snapshot(self) -> None:
        shown = await database_sync_to_async(self._snapshot)()
        await self.send(json.dumps(shown))

    def _snapshot(self) -> dict[str, Any]:
        return snapshot(self.slug, current_user(self.scope), SYSTEM.now(), hub_link(self.viewer))

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
            if viewer.frame is not None:
                frame, viewer.frame = viewer.frame, None
                await self.send(bytes_data=frame)
            if resync:
                await self._send_snapshot()


def hub_link(viewer: Viewer) -> bool:
    """Return the link's state as the viewer saw it last; called off the event loop."""
    return viewer.link
