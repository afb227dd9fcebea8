"""uvicorn's HTTP protocol with limits that it has no setting for: slow headers, floods, peers that do not read.

The limits bound the bytes of a request that are not its body (line, headers, the frame of each chunk, trailers), the
number of its headers and chunks, the requests that wait on one connection, and how much the system reads ahead. A
reverse proxy does most of this for its own connections; these limits also hold without a proxy, and behind one that
passes everything on.
"""

import asyncio
import ipaddress
import socket
from collections import deque
from functools import cache
from typing import Any

import httptools
from django.conf import settings
from uvicorn.protocols.http.httptools_impl import STATUS_LINE, HttpToolsProtocol

from portal.edge.dropped import drop
from portal.edge.sockets import FLUSH_S, Ws, connections
from portal.edge.unsent import Unread

HEAD = 32 * 1024  # bytes of a request besides its body
FIELDS = 100  # headers and trailers of a request
CHUNKS = 1000  # of a body
PIPELINED = 8  # requests that wait on a connection, the one that is served included; browsers send one
RECEIVED = 32 * 1024  # bytes that the system is asked to hold before we read them; it takes twice that
REFUSALS = {400: "sent no HTTP", 429: "sent too many requests at once", 431: "sent too many headers"}


class _TooMany(Exception):
    """A request has too many headers or chunks, or too many requests wait; the parser ends with it."""

    def __init__(self, status: int) -> None:
        super().__init__(status)
        self.status = status


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
    _unread: Unread | None = None
    _head = 0  # bytes since the last complete request that belong to no body
    _fields = _chunks = 0
    _heading = False  # headers are expected, not trailers
    _complete = False  # a request became complete in the last received data
    _counted = ""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._cycles: deque[Any] = deque()  # requests that are not answered yet: one is served, the others wait

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Count the connection, and wait for its first headers."""
        super().connection_made(transport)
        if self.client is None:  # reset before it was accepted
            transport.abort()
            return
        address = self.client[0]
        if not through_proxy(address):
            if not connections().enter(address):
                drop("of an address that has enough")
                self._refuse(503)
                return
            self._counted = address
        line = transport.get_extra_info("socket")
        if line is not None:
            line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVED)
        self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Remove the connection from the count, and tell all its requests; uvicorn tells only the newest one."""
        for cycle in self._cycles:
            if not cycle.response_complete:
                cycle.disconnected = True
                cycle.message_event.set()
        self._cycles.clear()
        self._cancel()
        self.uncount()
        super().connection_lost(exc)

    def uncount(self) -> None:
        """Remove the connection from the count."""
        if self._counted:
            connections().leave(self._counted)
            self._counted = ""

    def data_received(self, data: bytes) -> None:
        """Refuse data that is no request, or is too long; nothing is read after a refusal."""
        if self.transport.is_closing():
            return
        self._unset_keepalive_if_required()
        self._complete = False
        self._head += len(data)
        try:
            self.parser.feed_data(data)
        except httptools.HttpParserUpgrade:
            self._upgrade()
            return
        except httptools.HttpParserError as error:
            cause = error.__context__
            self._refuse(cause.status if isinstance(cause, _TooMany) else 400)
            return
        if self._complete:
            self._head = 0  # of the next request at most this data is not counted
        elif self._head > HEAD:
            self._refuse(431)

    def _upgrade(self) -> None:
        if not self._should_upgrade():
            self.cycle.keep_alive = False  # it is answered in HTTP/1.1; the bytes after it are in no known protocol
        elif self._cycles:
            self._refuse(400)  # the answers to the requests before it would be written into the socket
        else:
            self.handle_websocket_upgrade()

    def on_message_begin(self) -> None:
        """Begin a request, unless too many wait."""
        if len(self._cycles) >= PIPELINED:
            raise _TooMany(429)
        self._fields, self._chunks, self._heading = 0, 0, True
        super().on_message_begin()

    def on_header(self, name: bytes, value: bytes) -> None:
        """Take a header; trailers, for which nobody asks, are counted only."""
        self._fields += 1
        if self._fields > FIELDS:
            raise _TooMany(431)
        if self._heading:
            super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """Stop the timer of the headers; the application limits the time of the body."""
        self._heading = False
        if self._late is not None:
            self._late.cancel()
            self._late = None
        before = self.cycle
        super().on_headers_complete()
        if self.cycle is not None and self.cycle is not before:
            self._cycles.append(self.cycle)

    def on_body(self, body: bytes) -> None:
        """Take a part of the body; the application limits its size."""
        self._head -= len(body)
        super().on_body(body)

    def on_chunk_header(self) -> None:
        """Begin a chunk of a body."""
        self._chunks += 1
        if self._chunks > CHUNKS:
            raise _TooMany(400)

    def on_message_complete(self) -> None:
        """Note that the request is complete; the next bytes belong to the next one."""
        self._complete = True
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """Wait for the next headers, for a limited time; end the connection if the request is still being sent."""
        if self._cycles.popleft().more_body:
            self.transport.close()
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
        """Give a peer that takes nothing a limited time."""
        super().pause_writing()
        self._unread = Unread(self.loop, self.transport)

    def resume_writing(self) -> None:
        """Note that the peer reads again."""
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
        if status in REFUSALS:
            drop(REFUSALS[status])
        if any(cycle.response_started for cycle in self._cycles):
            self.transport.abort()  # a status in the middle of an answer would be part of it
        elif not self.transport.is_closing():
            self.transport.write(STATUS_LINE[status] + b"connection: close\r\ncontent-length: 0\r\n\r\n")
            self.transport.close()
            self.loop.call_later(FLUSH_S, self.transport.abort)
