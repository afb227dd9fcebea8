"""uvicorn's protocols with limits that it has no setting for: slow headers, floods, peers that do not read.

A reverse proxy does most of this for its own connections; these limits also hold without a proxy, and behind one that
passes everything on.
"""

import asyncio
import ipaddress
from functools import cache
from typing import Any

from django.conf import settings
from uvicorn.protocols.http.httptools_impl import STATUS_LINE, HttpToolsProtocol
from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame

from portal.limits.counts import AddressCount

HEAD = 64 * 1024  # bytes of a request's line and headers
UNSENT = 1024 * 1024  # bytes that may wait for a peer that does not read
FRAMES_S, FRAMES = 20.0, 200.0  # control frames and fragments a second, and at once
FLUSH_S = 5.0  # for sending the last bytes before a close
NO_TEXT, POLICY = 1007, 1008


@cache
def connections() -> AddressCount:
    """Return this process's counter of connections."""
    return AddressCount(settings.LIMITS["CONNECTIONS"])


@cache
def _proxies() -> tuple[Any, ...]:
    return tuple(ipaddress.ip_network(network) for network in settings.TRUSTED_PROXIES)


def through_proxy(address: str) -> bool:
    """Return whether the peer is a trusted proxy, which speaks for many people."""
    try:
        ip = ipaddress.ip_address(address)
    except ValueError:
        return False
    return any(ip in network for network in _proxies())


class Http(HttpToolsProtocol):
    """A connection whose requests must start, arrive and be read within limits."""

    _late: asyncio.TimerHandle | None = None
    _unread: asyncio.TimerHandle | None = None
    _heading, _head = True, 0  # headers are expected; bytes since the last complete headers
    _heads = 0  # complete headers in the last received data
    _counted = ""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Count the connection, and wait for its first headers."""
        super().connection_made(transport)
        address = self.client[0] if self.client else ""
        if address and not through_proxy(address):
            if not connections().enter(address):
                self._refuse(503)
                return
            self._counted = address
        self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Remove it from the count."""
        self._cancel()
        self.uncount()
        super().connection_lost(exc)

    def uncount(self) -> None:
        """Remove the connection from the count."""
        if self._counted:
            connections().leave(self._counted)
            self._counted = ""

    def data_received(self, data: bytes) -> None:
        """Refuse headers that are too long; nothing is read after a refusal."""
        if self.transport.is_closing():
            return
        self._heads = 0
        super().data_received(data)
        self._head = 0 if self._heads else self._head + len(data)
        if self._heading and self._head > HEAD:
            self._refuse(431)

    def on_headers_complete(self) -> None:
        """The headers are complete; the application limits the time of the body."""
        self._heading = False
        self._heads += 1
        if self._late is not None:
            self._late.cancel()
            self._late = None
        super().on_headers_complete()

    def on_message_complete(self) -> None:
        """The request is complete; the next bytes belong to the next headers."""
        self._heading = True
        self._heads += 1
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """Wait for the next headers, for a limited time."""
        super().on_response_complete()
        if self.transport.is_closing():
            self.loop.call_later(settings.LIMITS["READ_S"], self.transport.abort)
        elif self.cycle is None or self.cycle.response_complete:
            self._await_head()

    def handle_websocket_upgrade(self) -> None:
        """Pass the connection to the WebSocket protocol, with its count."""
        counted, self._counted = self._counted, ""
        self._cancel()
        super().handle_websocket_upgrade()
        protocol: Any = self.transport.get_protocol()
        if counted and isinstance(protocol, Ws) and not protocol.disconnected:
            protocol.counted = counted
        elif counted:
            connections().leave(counted)

    def pause_writing(self) -> None:
        """Give a peer that does not read a limited time."""
        super().pause_writing()
        self._unread = self.loop.call_later(settings.LIMITS["READ_S"], self.transport.abort)

    def resume_writing(self) -> None:
        """The peer reads again."""
        super().resume_writing()
        if self._unread is not None:
            self._unread.cancel()
            self._unread = None

    def _await_head(self) -> None:
        if self._late is not None:
            self._late.cancel()
        self._late = self.loop.call_later(settings.LIMITS["HEAD_S"], self._refuse, 408)

    def _cancel(self) -> None:
        for timer in (self._late, self._unread):
            if timer is not None:
                timer.cancel()
        self._late = self._unread = None

    def _refuse(self, status: int) -> None:
        self._cancel()
        if not self.transport.is_closing():
            self.transport.write(STATUS_LINE[status] + b"connection: close\r\ncontent-length: 0\r\n\r\n")
            self.transport.close()
            self.loop.call_later(FLUSH_S, self.transport.abort)


class Ws(WebSocketsSansIOProtocol):
    """A socket with limits for pings and fragments, which also ends if its peer does not read."""

    counted = ""
    _broken = False  # by the peer; uvicorn would report later sends as errors of the application
    _room, _filled = FRAMES, 0.0

    def handle_parser_exception(self) -> None:
        """End the socket because of data that is not WebSocket."""
        self._broken = True
        super().handle_parser_exception()

    async def send(self, message: Any) -> None:
        """Send for the application, which may not know yet that the peer broke the protocol."""
        if self._broken:
            raise ClientDisconnected
        await super().send(message)

    def data_received(self, data: bytes) -> None:
        """Receive data; frames before the handshake is answered end the connection (RFC 6455, 4.1)."""
        if self.handshake_initiated and not self.handshake_complete:
            self.transport.abort()
            return
        super().data_received(data)

    def connection_lost(self, exc: Exception | None) -> None:
        """Remove it from the count."""
        if self.counted:
            connections().leave(self.counted)
            self.counted = ""
        super().connection_lost(exc)

    def handle_ping(self) -> None:
        """Answer, unless pings come too fast or nobody reads the answers."""
        if self._may():
            super().handle_ping()

    def handle_pong(self, event: Frame) -> None:
        """Receive the answer to our ping."""
        if self._may():
            super().handle_pong(event)

    def handle_cont(self, event: Frame) -> None:
        """Receive a fragment; a message in very many fragments is refused."""
        if self._may():
            super().handle_cont(event)

    def send_receive_event_to_app(self) -> None:
        """Pass a message on; text that is not UTF-8 ends the socket without a traceback in the log."""
        if self.curr_msg_data_type == "text" and not self.close_sent:
            try:
                b"".join(self.frames).decode()
            except UnicodeDecodeError:
                self._fail(NO_TEXT, "no UTF-8")
                return
        super().send_receive_event_to_app()

    def _may(self) -> bool:
        if self.close_sent or self.transport.is_closing():
            return False
        now = self.loop.time()
        self._room = min(FRAMES, self._room + (now - self._filled) * FRAMES_S) - 1
        self._filled = now
        if self.transport.get_write_buffer_size() > UNSENT:
            self.transport.abort()
            return False
        if self._room < 0:
            self._fail(POLICY, "too many frames")
            return False
        return True

    def _fail(self, code: int, reason: str) -> None:
        self.frames = []
        self.conn.fail(code, reason)
        self.handle_parser_exception()
        self._flush()

    def keepalive_timeout(self) -> None:
        """End the connection: a peer that does not answer will not read a close either."""
        super().keepalive_timeout()
        self._flush()

    def on_task_complete(self, task: "asyncio.Task[None]") -> None:
        """End the connection soon after the application has finished."""
        super().on_task_complete(task)
        self._flush()

    def _flush(self) -> None:
        self.loop.call_later(FLUSH_S, self._cut)

    def _cut(self) -> None:
        if not self.disconnected:
            self.transport.abort()
