"""The web process inside the test's process, with its arguments, so that its objects can be counted."""

import asyncio
import contextlib
import json
import threading
import time  # noqa: TID251 - the limit of a wait

import uvicorn
from django.db import connections
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from benchmarks.command_round_trip import cookie
from portal.live import previews, sessions, threads
from portal.run import serve
from tests.conftest import wait_for
from tests.rig import free_port

OF_SOCKETS = (
    "RobotSocket", "Socket", "Writer", "SnapshotSender", "Requests", "Presence", "PlanSender",
    "WebSocketsSansIOProtocol", "Ws",
)  # fmt: skip


class WebHere:
    """A web process in a thread of this one."""

    def __init__(self):
        self.port = free_port()
        self.server = uvicorn.Server(serve.config("127.0.0.1", self.port))
        self.url = f"http://localhost:{self.port}"
        self.loop = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        wait_for(lambda: self.server.started, 30, "the web process")

    def _run(self):
        async def serve():
            self.loop = asyncio.get_running_loop()
            await self.server._serve()  # `serve` takes over the signals, which belong to the main thread

        asyncio.run(serve())
        connections.close_all()

    def ask(self, function):
        """Return what `function` answers in the loop of the web process."""

        async def call():
            return function()

        return asyncio.run_coroutine_threadsafe(call(), self.loop).result(10)

    def left(self):
        """Return what the web process holds for sockets: viewers, robots listened to, sockets, tasks, connections."""

        def count():
            from portal.live.loop import of_loop
            from portal.live.socket import sockets

            here = of_loop().hub
            names = [t.get_coro().__qualname__ for t in asyncio.all_tasks()]
            pubsub = here._reader.pubsub.channels if here._reader.pubsub is not None else {}
            return {
                "viewers": sum(len(room.viewers) for room in here._rooms.values()),
                "pictures": sum(len(room.newest) for room in here._rooms.values()),
                "robots listened to": sum(b":state" in name for name in pubsub),
                "sockets": len(sockets),
                "tasks": sum(n.partition(".")[0] in OF_SOCKETS or n.startswith("Hub._follow") for n in names),
                "connections": len(self.server.server_state.connections),
            }  # fmt: skip

        return self.ask(count)

    def nothing_left(self, seconds=15):
        """Wait until nothing is left of any socket."""
        try:
            wait_for(lambda: not any(self.left().values()), seconds, "an empty web process")
        except AssertionError as error:
            raise AssertionError(f"{error}; left behind: {self.left()}") from error

    def stop(self):
        self.server.should_exit = True
        self._thread.join(10)
        for pool in (previews.PREPARE, sessions.SESSIONS, threads.URGENT, threads.DRIVERS, threads.KNOWN,
                     threads.EVERYBODY, threads.ANYBODY):  # fmt: skip
            _close_connections(pool._executor)
        with contextlib.suppress(RuntimeError):
            self.loop.close()


def _close_connections(executor):
    """Have each thread of a pool close its connections to the database, which they keep for the next request."""
    number = len(executor._threads)
    all_here = threading.Barrier(number or 1)
    for done in [executor.submit(lambda: (all_here.wait(10), connections.close_all())) for _ in range(number)]:
        done.result(20)


def line(web, person=None, path="/ws/robots/mercury/", headers=None, **more):
    """Open a socket as a page of the site does."""
    headers = headers or ({"Cookie": cookie(person)} if person else {})
    where = f"127.0.0.1:{web.port}"
    return connect(f"ws://{where}{path}", origin=f"http://{where}", additional_headers=headers, max_size=None, **more)


def handshake(web, path="/ws/robots/mercury/", cookie=None):
    """Return the bytes that open a socket."""
    more = f"Cookie: {cookie}\r\n" if cookie else ""
    return (
        f"GET {path} HTTP/1.1\r\nHost: localhost:{web.port}\r\nOrigin: http://localhost:{web.port}\r\n{more}Upgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    ).encode()


def heard(one, what, seconds=10):
    """Read until a message `what` comes; return it."""
    until = time.monotonic() + seconds
    while True:
        data = one.recv(timeout=max(0.01, until - time.monotonic()))
        if isinstance(data, str) and (said := json.loads(data))["t"] == what:
            return said


def closed(one, seconds=10):
    """Read until the socket is closed; return code and reason."""
    until = time.monotonic() + seconds
    try:
        while True:
            one.recv(timeout=max(0.01, until - time.monotonic()))
    except ConnectionClosed as end:
        return (end.rcvd.code, end.rcvd.reason) if end.rcvd else (None, "")
