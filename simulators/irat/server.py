"""The robot's network: rosbridge v2 over WebSocket, in a thread and an event loop of its own.

Only this machine is served, and no page in a browser, which would otherwise reach a robot on its user's machine.
"""

import asyncio
import contextlib
import logging
import threading
from collections.abc import Callable, Iterable
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from robots.clock import TIMER, WALL, Timer, Wall
from robots.drivers.rosbridge import MOST_BYTES, Message, encode
from simulators.common.faults import FaultBoard
from simulators.irat.operations import Operations, Robot
from simulators.irat.peer import Peer

Note = Callable[..., None]
MOST_PEERS = 32  # the oldest that does not command goes for a new one
MOST_SOCKETS = 64  # with those that have not said yet what they are
MOST_WAITING = 16  # accepted at once, in each turn of the loop; one that is too many is closed some turns later
OPEN_S, PING_S = 5.0, 5.0  # real time, as the next: the network's
LOOK_S = 0.05
log = logging.getLogger("simulators.irat.websockets")
log.setLevel(logging.CRITICAL)  # whatever strangers send is no news; the journal has what matters


class Network:
    """Listens on `port` (0: any)."""

    def __init__(
        self, port: int, robot: Robot, faults: FaultBoard, note: Note, clock: Timer = TIMER, wall: Wall = WALL
    ) -> None:
        self._faults, self._note, self._clock = faults, note, clock
        self._peers: list[Peer] = []
        self._sockets: list[ServerConnection] = []
        self._operations = Operations(robot, note, clock, wall)
        self.watched: frozenset[str] = frozenset()  # topics that somebody subscribes to
        self.off = False  # without power: nobody is answered
        self.port, self._sequence = port, 0
        self._loop = asyncio.new_event_loop()
        self._over: asyncio.Event
        ready = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(ready,), name="network", daemon=True)
        self._thread.start()
        ready.wait()

    @property
    def epoch(self) -> int:
        """Return the commander's epoch, 0 if there is none."""
        return self._operations.claims.epoch

    @property
    def _silent(self) -> bool:
        return self.off or bool(self._faults.value("awol"))

    def publish(self, messages: Iterable[tuple[str, Callable[[int], Message]]]) -> None:
        """Send messages of topics to those who want them now; each is made once, with its number."""
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._publish, list(messages))

    def power_off(self) -> None:
        """End all connections at once, and forget who commanded."""
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._power_off)

    def close(self) -> None:
        """Stop listening and end all connections."""
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(3)

    def _run(self, ready: threading.Event) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.set_exception_handler(self._failed)
        self._loop.run_until_complete(self._serve(ready))

    def _failed(self, loop: asyncio.AbstractEventLoop, what: dict[str, Any]) -> None:
        self._note("crash", error=str(what.get("exception") or what["message"]))

    async def _serve(self, ready: threading.Event) -> None:
        self._over = asyncio.Event()
        async with serve(
            self._serve_one, "127.0.0.1", self.port, origins=[None], compression=None, max_size=MOST_BYTES,
            max_queue=8, open_timeout=OPEN_S, ping_interval=PING_S, ping_timeout=2 * PING_S, close_timeout=1.0,
            process_request=self._admit, create_connection=self._connection(), logger=log, server_header=None,
            backlog=MOST_WAITING,
        ) as server:  # fmt: skip
            self.port = next(iter(server.sockets)).getsockname()[1]
            ready.set()
            await self._over.wait()
            self._power_off()

    def _connection(self) -> type[ServerConnection]:
        network = self

        class Connection(ServerConnection):
            """Counted from its first byte on, so that silent sockets do not use up all descriptors."""

            def connection_made(self, transport: asyncio.BaseTransport) -> None:
                super().connection_made(transport)
                network._sockets.append(self)
                if len(network._sockets) > MOST_SOCKETS:
                    known = {id(peer.line) for peer in network._peers}
                    oldest = next((line for line in network._sockets if id(line) not in known), network._sockets[0])
                    network._sockets.remove(oldest)  # at once: it ends later, and many come before
                    oldest.transport.abort()

            def connection_lost(self, exc: Exception | None) -> None:
                super().connection_lost(exc)
                with contextlib.suppress(ValueError):
                    network._sockets.remove(self)

        return Connection

    async def _admit(self, line: ServerConnection, request: Request) -> Response | None:
        """Let a handshake wait while the radio is silent; its client gives up some day."""
        while self._silent:
            await asyncio.sleep(LOOK_S)
        return None if request.path == "/" else line.respond(HTTPStatus.NOT_FOUND, "rosbridge is at /\n")

    async def _serve_one(self, line: ServerConnection) -> None:
        peer = Peer(line, self._faults, self._clock)
        self._peers.append(peer)
        self._make_room()
        writer = asyncio.create_task(peer.write())
        try:
            async for data in line:
                await peer.within_rate()
                if not self._silent:
                    self._take(peer, data)
        except (ConnectionClosed, OSError):
            pass
        finally:
            writer.cancel()
            with contextlib.suppress(ValueError):
                self._peers.remove(peer)
            self._look()
            self._operations.leave(peer)

    def _make_room(self) -> None:
        if len(self._peers) > MOST_PEERS:
            oldest = next(p for p in self._peers if p is not self._operations.claims.commander)
            self._peers.remove(oldest)
            oldest.line.transport.abort()

    def _take(self, peer: Peer, data: str | bytes) -> None:
        """Do what a frame asks for. Whatever is in it, the next frame is read, too."""
        try:
            self._operations.take(peer, data)
        except Exception as error:  # noqa: BLE001 - one frame must not end the others' service
            self._note("crash", error=f"{type(error).__name__}: {error}")
            peer.answer(encode(op="status", level="error", msg="the robot failed at this frame"))
        self._look()

    def _look(self) -> None:
        self.watched = frozenset(topic for peer in self._peers for topic in peer.subscriptions)

    def _publish(self, messages: list[tuple[str, Callable[[int], Message]]]) -> None:
        now, self._sequence = self._clock.monotonic(), self._sequence + 1
        for topic, make in messages:
            wanting = [peer for peer in self._peers if peer.wants(topic, now)]
            if wanting:
                frame = encode(op="publish", topic=topic, msg=make(self._sequence))
                for peer in wanting:
                    peer.show(topic, frame)

    def _power_off(self) -> None:
        self._operations.claims.forget()
        for line in list(self._sockets):
            line.transport.abort()
