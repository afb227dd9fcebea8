"""Base class of sockets: messages are limited, and each socket ends cleanly after any message or exception."""

import asyncio
import contextlib
import logging
from collections.abc import Callable, Coroutine
from typing import Any, ClassVar

from channels.exceptions import StopConsumer
from channels.generic.websocket import AsyncWebsocketConsumer

from portal.edge.direct import connection_of
from portal.edge.dropped import drop
from portal.edge.limits import AddressRate, Bucket
from portal.live.audience import Seat
from portal.live.loop import LoopState, of_loop
from portal.live.messages import NotUnderstood, Wire
from portal.live.people import Role, session_key
from portal.live.sessions import Ending, SignIn
from portal.live.threads import Pool
from robots.kit.clock import SYSTEM

log = logging.getLogger(__name__)
RATE, BURST = 30.0, 60.0  # messages a second of one socket, and at once
CALM, CALM_BURST = 3.0, 30.0  # a socket within this rate stays open though others of its network address send too many
OF_ADDRESS = AddressRate(rate=500.0, burst=3000.0)  # of all sockets of a network address; a page sends one in 5 s
BAD_MESSAGE, TOO_FAST, FAILED = 4400, 4429, 1011
CLOSE_S = 1.0  # for sending a close
AGAIN_S = 1.0  # between two attempts to end a task
LEAVE_S = 5.0  # for the work after a socket has ended


class Socket(AsyncWebsocketConsumer):  # type: ignore[misc]
    """A socket. Subclasses define the messages (`wire`) and `prepare`, `open`, `take`, `refuse` and `release`."""

    wire: ClassVar[Wire[Any]]
    shared: LoopState
    protocol: str | None = None  # the WebSocket subprotocol that is spoken with a peer that offers it
    pool: Pool | None = None  # the threads for its queries; None: those for the person's role
    sign_in: SignIn | None = None
    role = Role()
    closed = False

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.seat = Seat()  # counts what is sent
        self._own, self._calm = Bucket(RATE, BURST), Bucket(CALM, CALM_BURST)
        self._tasks: dict[asyncio.Task[None], None] = {}  # in the order in which they began
        self._main: asyncio.Task[Any] | None = None
        self._cut = False
        self.lost_by = ""  # why the connection ended, where that is known

    def prepare(self) -> None:
        """Make the parts of the socket; `scope` and `shared` are known."""

    async def open(self) -> None:
        """Start; the socket is accepted."""

    async def take(self, message: Any) -> None:
        """Carry out a message."""

    async def refuse(self, error: NotUnderstood) -> None:
        """Answer a message that was not understood; the socket stays open."""

    async def release(self) -> None:
        """Release everything; called once, however the socket ended, after its tasks have ended."""

    @property
    def stranger(self) -> bool:
        """Return whether nobody is signed in, and nobody will be: a sign-in makes a new session."""
        return self.role.anonymous or not session_key(self.scope)

    async def orm(self, function: Callable[..., Any], *args: Any) -> Any:
        """Query the database in the threads for this kind of person."""
        return await (self.pool or self.role.pool).orm(function, self.role.person)(*args)

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Serve the socket to its end; its tasks are ended after any exception."""
        self.scope, self.shared = scope, of_loop()
        sockets.add(self)
        self._main = asyncio.current_task()
        try:
            self.prepare()
            await super().__call__(scope, receive, send)
        except asyncio.CancelledError:
            if not self._cut:
                raise
        finally:
            self.closed = True
            sockets.discard(self)
            self.shared.sessions.remove(self)
            await self._clear()

    async def _clear(self) -> None:
        while self._tasks:  # again, because a task may have missed a cancellation
            for task in self._tasks:
                task.cancel()
            await asyncio.wait(list(self._tasks), timeout=AGAIN_S)
        try:
            async with asyncio.timeout(LEAVE_S):
                await self.release()
        except Exception as error:  # noqa: BLE001 - a store may be away; nothing depends on this
            log.debug("the work after the end of a socket failed: %s", error)

    async def dispatch(self, message: dict[str, Any]) -> None:
        """Handle one event; an error of ours ends this socket only.

        Channels closes old database connections here, in the one thread that all sockets share; our threads do that for
        themselves.
        """
        if message["type"] == "websocket.disconnect":
            connection = connection_of(self.scope)
            if not self.closed:  # else we closed it, and told the page why
                self.lost_by = getattr(connection, "cause", "")
            raise StopConsumer
        if self.closed:
            return
        try:
            if message["type"] == "websocket.connect":
                offered = self.scope.get("subprotocols", ())
                await self.accept(self.protocol if self.protocol in offered else None)
                await self.open()
            else:
                await self._receive(message.get("text"), message.get("bytes"))
        except OSError as error:  # the connection was just lost; `disconnect` follows
            log.debug("a socket's connection was lost: %s", error)
        except Exception:
            log.exception("a socket failed")
            await self.close(FAILED)

    def _may(self, now: float) -> bool:
        """Return whether the peer may send one more message; an operator is not counted for the network address."""
        return self._own.take(now) and (self.role.grant > 0 or self._of_address_or_calm(now))

    def _of_address_or_calm(self, now: float) -> bool:
        calm, address = self._calm.take(now), str((self.scope.get("client") or ("",))[0])
        return OF_ADDRESS.take(address) or calm

    def read(self, text: str | None, data: bytes | None) -> Any:
        """Return the message in a frame; None if that is a part of one. Raises NotUnderstood."""
        return self.wire.decode(text)

    async def _receive(self, text: str | None, data: bytes | None) -> None:
        if not self._may(SYSTEM.awake()):
            drop("sent too many messages")
            await self.close(TOO_FAST)
            return
        try:
            message = self.read(text, data)
        except NotUnderstood as error:
            if error.hopeless:
                await self.close(BAD_MESSAGE)
            else:
                await self.refuse(error)
            return
        if message is not None:
            await self.take(message)

    def begin(self, coroutine: Coroutine[Any, Any, None]) -> None:
        """Run a task of this socket; it ends with the socket, and if it fails, the socket ends."""
        task = asyncio.create_task(coroutine)
        self._tasks[task] = None
        task.add_done_callback(self._ended)

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.pop(task, None)
        if task.cancelled() or task.exception() is None:
            return
        log.error("a socket's task failed", exc_info=task.exception())
        if not self.closed:
            self.begin(self.close(FAILED))

    async def send(self, text_data: str | None = None, bytes_data: bytes | None = None, close: bool = False) -> None:
        """Send, and count the bytes; a connection that has ended, or ends meanwhile, is not an error."""
        self.seat.sent_bytes += len(bytes_data if bytes_data is not None else text_data or "")
        if self.closed:
            return
        with contextlib.suppress(OSError):
            await super().send(text_data, bytes_data, close)

    async def close(self, code: int | None = None, reason: str | None = None) -> None:
        """Close the socket; a peer that does not read is cut off. Can be repeated."""
        if self.closed:
            return
        self.closed = True
        try:
            async with asyncio.timeout(CLOSE_S):
                await super().close(code, reason)
        except TimeoutError:
            self._cut = True
            if self._main is not None:
                self._main.cancel()
        except OSError:
            pass

    def sign(self, sign_in: SignIn | None) -> None:
        """Note the sign-in of the socket's person; it ends with their session."""
        if sign_in is not None and self.sign_in is None and not self.closed:
            self.sign_in = sign_in
            self.shared.sessions.add(self)

    def judge(self, user: Any) -> Ending | None:
        """Return why the socket must end though its session may go on; runs in a thread."""
        return None

    def check_in(self) -> None:
        """Note soon in the database that the person is present."""

    async def shut(self, ending: Ending) -> None:
        """Close the socket because its person may no longer use it."""
        await self.close(ending.code, ending.text)


sockets: set[Socket] = set()  # the sockets that this process serves
