"""uvicorn's HTTP protocol with limits that it has no setting for: slow headers, floods, peers that do not read.

A reverse proxy does most of this for its own connections; these limits also hold without a proxy, and behind one that
passes everything on.
"""

import asyncio
import ipaddress
from collections import deque
from functools import cache
from typing import Any

from django.conf import settings
from uvicorn.protocols.http.httptools_impl import STATUS_LINE, HttpToolsProtocol

from portal.limits.dropped import drop
from portal.limits.sockets import FLUSH_S, Ws, connections
from portal.limits.unsent import Unread

HEAD = 64 * 1024  # bytes of a request's line and headers


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
    _heading, _head = True, 0  # headers are expected; bytes since the last complete headers
    _heads = 0  # complete headers in the last received data
    _counted = ""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._cycles: deque[Any] = deque()  # requests that are not answered yet: one is served, the others wait

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Count the connection, and wait for its first headers."""
        super().connection_made(transport)
        address = self.client[0] if self.client else ""
        if address and not through_proxy(address):
            if not connections().enter(address):
                drop("of an address that has enough")
                self._refuse(503)
                return
            self._counted = address
        self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Remove it from the count, and tell the request that is served; uvicorn tells the newest one alone."""
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
        before = self.cycle
        super().on_headers_complete()
        if self.cycle is not None and self.cycle is not before:
            while self._cycles and self._cycles[0].response_complete:
                self._cycles.popleft()
            self._cycles.append(self.cycle)

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
        """Give a peer that takes nothing a limited time."""
        super().pause_writing()
        self._unread = Unread(self.loop, self.transport)

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
