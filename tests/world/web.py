"""The web process of a world, which serves sockets in an event loop of the world; browsers of people, and their pages."""

import json
from collections import deque
from math import inf

from django.conf import settings
from django.test import Client

from tests.world.loop import WorldLoop
from tests.world.wires import Wire
from tests.world.world import World

PING_S = 2.0  # between two reports of a robot's page
NO_PICTURES = b'watch={"t": "watch", "cameras": []}'  # which cost more than all else here
AT_ROBOT, AT_ME = "/ws/robots/{}/", "/ws/me/"


class Sockets:
    """The event loop of the web process, and what is served in it."""

    def __init__(self, world: World) -> None:
        from portal.asgi import application

        self.world, self.application = world, application
        self.process = world.process("web")
        self.loop: WorldLoop | None = None
        world.spawn(self._run, "sockets", self.process)
        world.until(lambda: self.loop is not None, 60, "the event loop")

    def _run(self) -> None:
        self.loop = WorldLoop(self.world)
        self.loop.serve()


class Browser:
    """A browser in which somebody is signed in."""

    def __init__(self, sockets: Sockets, user) -> None:
        self.sockets, self.name = sockets, user.username
        self._client = Client(HTTP_HOST="localhost")
        self._client.force_login(user)

    def sign_out(self) -> None:
        assert self._client.post("/accounts/logout/").status_code == 302

    def open(self, path: str) -> "Page":
        """Open a page with its socket."""
        cookie = f"{settings.SESSION_COOKIE_NAME}={self._client.cookies[settings.SESSION_COOKIE_NAME].value}"
        return Page(self.sockets, path, cookie, self.name)


class Page:
    """The socket of one page, at its real address. Without a cookie it is a stranger's.

    `code`: with which it was closed, None while it is open; `newest`: what came last of each kind of message; `packets`:
    the binary messages that have come.
    """

    def __init__(self, sockets: Sockets, path: str, cookie: str = "", name: str = "a stranger") -> None:
        self._world, self._loop = sockets.world, sockets.loop
        self.wire, self._at_robot = Wire(self._world), path != AT_ME
        self.code: int | None = None
        self.newest: dict[str, dict] = {}
        self.answers: list[dict] = []
        self.packets: list[bytes] = []
        self._to_server, self._to_page = deque([{"type": "websocket.connect"}]), deque()
        self._world.spawn(self._live, f"{name}'s page", self._world.process(f"{name}'s page"))
        headers = {b"host": b"localhost", b"origin": b"http://localhost", b"cookie": cookie.encode()}
        scope = {
            "type": "websocket", "path": path, "query_string": NO_PICTURES, "headers": list(headers.items()),
            "client": ("192.0.2.1", 40000), "subprotocols": [], "extensions": {},
        }  # fmt: skip
        served = sockets.application(scope, self._receive, self._send)
        self._loop.call_soon_threadsafe(self._begin, served)

    def _begin(self, served) -> None:
        self._served = self._loop.create_task(served)

    # the server's side

    async def _receive(self) -> dict:
        await self._loop.until(lambda: self._to_server and self.wire.carries)
        return self._to_server.popleft()

    async def _send(self, message: dict) -> None:
        self._to_page.append(message)

    # the page's side

    def _live(self) -> None:
        """Read what comes, and report."""
        world, ping_at = self._world, self._world.monotonic() if self._at_robot else inf
        while self.code is None:
            if world.park(ping_at, lambda: self._to_page and self.wire.carries):
                self._read(self._to_page.popleft())
            else:
                ping_at += PING_S
                self.say("ping")

    def _read(self, message: dict) -> None:
        if message["type"] == "websocket.close":
            self.code = message.get("code", 1000)
        elif data := message.get("bytes"):
            self.packets.append(data)
        elif said := message.get("text"):
            told = json.loads(said)
            if told["t"] == "answer":
                self.answers.append(told)
            else:
                self.newest[told["t"]] = told
                if not self._at_robot:
                    self.say("here")

    @property
    def snapshot(self) -> dict:
        return self.newest.get("snapshot", {})

    def say(self, what: str, /, **fields) -> None:
        """Send a message."""
        self._to_server.append({"type": "websocket.receive", "text": json.dumps({"t": what, **fields})})

    def close(self) -> None:
        """Close the page."""
        self.code = 1001
        self._to_server.append({"type": "websocket.disconnect", "code": self.code})
