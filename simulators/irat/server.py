"""The robot's network: rosbridge v2 over WebSocket, in a thread and an event loop of its own.

Only programs of this machine are served, and no page in a browser: any web page could otherwise drive the robot.
"""

import asyncio
import contextlib
import logging
import threading
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from robots.kit.clock import TIMER, Limit, Timer
from robots.kit.drivers.rosbridge import MOST_BYTES
from simulators.common.faults import FaultBoard
from simulators.common.journal import Note
from simulators.irat.peer import Peer
from simulators.irat.radio import Messages, Radio

MOST_SOCKETS = 64  # including those whose handshake is not over
MOST_WAITING = 16  # connections that one turn of the loop accepts; one too many is closed some turns later
OPEN_S, PING_S = 5.0, 5.0  # real time, as the next ones: they protect the machine
A_SECOND, BURST = 400.0, 400.0  # messages of a client; a faster sender has to wait
UNREAD_S = 5.0  # longest wait of a frame for a client that does not read
SILENT_LOOK_S, LATE_LOOK_S = 0.05, 0.005  # between two looks whether the radio speaks again, and at the clock
log = logging.getLogger("simulators.irat.websockets")
log.setLevel(logging.CRITICAL)  # strangers must not fill the log; the journal has what matters


class SocketPeer(Peer):
    """A client behind a WebSocket; all methods are called in the event loop. `real` measures its rate."""

    def __init__(self, line: ServerConnection, faults: FaultBoard, clock: Timer = TIMER, real: Timer = TIMER) -> None:
        self.line, self._real, self._ready = line, real, asyncio.Event()
        name = ":".join(map(str, (line.remote_address or ("?", 0))[:2]))
        super().__init__(name, faults, self._ready.set, line.transport.abort, clock)
        self._room, self._filled = BURST, real.monotonic()

    async def within_rate(self) -> None:
        """Let other tasks run; wait if this client sends too fast (a token bucket)."""
        now = self._real.monotonic()
        self._room = min(BURST, self._room + (now - self._filled) * A_SECOND)
        self._filled, self.heard_at = now, self._clock.monotonic()
        self._room -= 1
        # even 0 s: to read frames that have arrived already does not let other tasks run
        await asyncio.sleep(max(0.0, -self._room / A_SECOND))

    async def _pause(self, seconds: float) -> None:
        limit = Limit(self._clock, seconds)
        while not limit.over:
            await asyncio.sleep(LATE_LOOK_S)

    async def write(self) -> None:
        """Send what waits until the connection ends."""
        try:
            while True:
                await self._ready.wait()
                self._ready.clear()
                while (frame := self.next()) is not None:
                    if self.slow_s:
                        await self._pause(self.slow_s)
                    async with asyncio.timeout(UNREAD_S):
                        await self.line.send(frame)
        except TimeoutError:
            self.cut()
        except ConnectionClosed:
            return


class Network:
    """Serves a radio on `port` (0: any). The radio's methods are called in the event loop alone."""

    def __init__(self, port: int, radio: Radio, faults: FaultBoard, note: Note, clock: Timer = TIMER) -> None:
        self._radio, self._faults, self._note, self._clock = radio, faults, note, clock
        self._sockets: list[ServerConnection] = []
        self.port = port
        self._loop = asyncio.new_event_loop()
        self._over: asyncio.Event
        ready = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(ready,), name="network", daemon=True)
        self._thread.start()
        ready.wait()

    def publish(self, messages: Messages) -> None:
        """Send messages of topics to the clients for which they are due; each is made once, with its number."""
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._radio.publish, list(messages))

    def settle(self) -> None:
        """Answer holds; called after each tick of the robot."""
        if self._radio.holds:
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._radio.settle)

    def power_off(self) -> None:
        """End all connections at once, and forget the commander."""
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
            """A connection that counts before its handshake, so that silent sockets do not use up all descriptors."""

            def connection_made(self, transport: asyncio.BaseTransport) -> None:
                super().connection_made(transport)
                network._sockets.append(self)
                if len(network._sockets) > MOST_SOCKETS:
                    known = {id(peer.line) for peer in network._radio.peers if isinstance(peer, SocketPeer)}
                    oldest = next((line for line in network._sockets if id(line) not in known), network._sockets[0])
                    network._sockets.remove(oldest)  # at once: it ends later, and many come before
                    oldest.transport.abort()

            def connection_lost(self, exc: Exception | None) -> None:
                super().connection_lost(exc)
                with contextlib.suppress(ValueError):
                    network._sockets.remove(self)

        return Connection

    async def _admit(self, line: ServerConnection, request: Request) -> Response | None:
        """Let a handshake wait while the radio is silent, until its client gives up."""
        while self._radio.silent:
            await asyncio.sleep(SILENT_LOOK_S)
        return None if request.path == "/" else line.respond(HTTPStatus.NOT_FOUND, "rosbridge is at /\n")

    async def _serve_one(self, line: ServerConnection) -> None:
        peer = SocketPeer(line, self._faults, self._clock)
        self._radio.join(peer)
        writer = asyncio.create_task(peer.write())
        try:
            async for data in line:
                await peer.within_rate()
                self._radio.take(peer, data)
        except (ConnectionClosed, OSError):
            pass
        finally:
            writer.cancel()
            self._radio.leave(peer)

    def _power_off(self) -> None:
        self._radio.power_off()
        for line in list(self._sockets):
            line.transport.abort()
