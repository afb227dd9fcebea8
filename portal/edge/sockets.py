"""uvicorn's WebSocket protocol with limits that it has no setting for, and connections offered to the application."""

import asyncio
import socket
from collections.abc import Callable
from functools import cache
from typing import Any

from django.conf import settings
from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame, Opcode
from websockets.http11 import Request

from portal.edge.compression import DEFLATE, Deflate, suits, text_frames
from portal.edge.direct import NAME, binary_frame
from portal.edge.dropped import drop
from portal.edge.limits import AddressCount, Bucket
from portal.edge.unsent import Unread
from portal.edge.window import PAYLOAD, CountedTransport, SendWindow

UNSENT = 1024 * 1024  # bytes that may wait for a peer that does not read
FRAMES_S, FRAMES = 20.0, 200.0  # control frames and fragments a second, and at once
FLUSH_S = 5.0  # for sending the last bytes before a close
NO_TEXT, POLICY = 1007, 1008
LOST = CLOSED_BY_PAGE, NO_PONG, NOT_READ, RESTART, CUT = "page", "no_pong", "not_read", "restart", "cut"
BEFORE = 64 * 1024  # bytes that may wait before an ordinary message has to
AHEAD = 8 * 1024  # bytes that the system may hold unsent; on a slow line more would only be old pictures


@cache
def connections() -> AddressCount:
    """Return this process's counter of connections."""
    return AddressCount(settings.LIMITS["CONNECTIONS"])


def _content(message: str | bytes) -> tuple[Opcode, bytes]:
    return (Opcode.TEXT, message.encode()) if isinstance(message, str) else (Opcode.BINARY, message)


class Ws(WebSocketsSansIOProtocol):
    """A socket with limits for pings and fragments, which also ends if its peer does not read.

    Its connection is offered to the application (see `portal.edge.direct`), for which it is free as long as nothing
    waits to be written and, once it is bounded, no more is on the way than `SendWindow` lets. The ordinary `send`
    waits only behind more than `BEFORE` bytes.
    """

    counted = ""
    deflates = _ready = False
    _kept = False  # the application lets nothing be written at once
    _taken = True  # nothing waits to be written
    _closed = False  # a close was sent, or the connection is lost
    cause = ""  # why the connection ended, one of `LOST`, where that is known; without one it was cut on its way
    _broken = False  # by the peer; uvicorn would report later sends as errors of the application
    _unread: Unread | None = None
    _window: SendWindow | None = None
    _deflate: Deflate | None = None
    _call: Callable[[], None] | None = None
    _call_ready: Callable[[], None] | None = None

    def connection_made(self, transport: Any) -> None:
        """Bound the bytes that wait on the way to a slow peer."""
        super().connection_made(transport)
        self._frames = Bucket(FRAMES_S, FRAMES)
        self.write = transport.write
        if self.config.ws_per_message_deflate:
            self.conn.available_extensions = [DEFLATE]
        transport.set_write_buffer_limits(high=1, low=0)
        line = transport.get_extra_info("socket")
        if line is not None and hasattr(socket, "TCP_NOTSENT_LOWAT") and line.family != socket.AF_UNIX:
            line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, AHEAD)

    def handle_connect(self, event: Request) -> None:
        """Offer the connection to the application."""
        super().handle_connect(event)
        if not self.close_sent:
            extensions: Any = self.scope["extensions"]
            extensions[NAME] = {"connection": self}
            self.deflates = any(suits(extension) for extension in self.conn.extensions)
            self._deflate = next((one for one in self.conn.extensions if isinstance(one, Deflate)), None)

    def free(self) -> bool:
        """Return whether it is open, and everything written before has been taken by the network, or by the peer."""
        return self._taken and not self.is_closing() and not (self._window is not None and self._window.full)

    def bound(self, on: bool) -> None:
        """Let no more be on the way than a thin line carries in a moment, or no longer; whoever writes is counted."""
        if on == (self._window is not None) or self.is_closing():
            return
        if isinstance(self.transport, CountedTransport):
            self.transport = self.transport.transport
        self._window = SendWindow() if on else None
        if on:
            self.transport = CountedTransport(self.transport, self._wrote)  # type: ignore[assignment]
        self.write = self.transport.write
        self._judge()
        if self._call_ready is not None:
            self._call_ready()  # also where it is as ready as before: it is written to in another way
        if not on and self._call is not None:
            self._call()

    def remember(self, on: bool) -> None:
        """Compress messages against those before from now on, or texts each by itself again."""
        if self._deflate is not None:
            self._deflate.remember(on)

    def frame(self, message: str | bytes) -> bytes:
        """Return the frame of a message for this connection alone, which has to be written next."""
        if self._deflate is None or not self._deflate.remembers:
            return text_frames(message)[self.deflates] if isinstance(message, str) else binary_frame(message)
        opcode, data = _content(message)
        return Frame(opcode, data).serialize(mask=False, extensions=[self._deflate])

    def size(self, message: str | bytes) -> int:
        """Return how many bytes it would take."""
        if self._deflate is None or not self._deflate.remembers:
            return len(text_frames(message)[self.deflates]) if isinstance(message, str) else len(message)
        return self._deflate.size(_content(message)[1])

    @property
    def window(self) -> int:
        """Return how many bytes may be on the way; 0: any number."""
        return 0 if self._window is None else self._window.size

    def _wrote(self, size: int) -> None:
        if self._window is not None:
            self._follow(self._window.wrote(size, self.loop.time()))
            self._judge()

    def _follow(self, ping: bytes | None) -> None:
        """Let a ping follow what was written, which the window has counted with it."""
        if ping is not None and isinstance(self.transport, CountedTransport) and not self.is_closing():
            self.transport.transport.write(Frame(Opcode.PING, ping).serialize(mask=False))

    def is_closing(self) -> bool:
        """Return whether nothing can be written any more."""
        return self.close_sent or self.transport.is_closing()

    def keep(self, waits: bool) -> None:
        """Note whether something waits that comes before any frame; while it does, the connection is not `ready`."""
        self._kept = waits
        self._judge()

    @property
    def ready(self) -> bool:
        """Return whether a frame may be written at once."""
        return self._ready

    @ready.setter
    def ready(self, ready: bool) -> None:
        if ready != self._ready:
            self._ready = ready
            if self._call_ready is not None:
                self._call_ready()

    def when_ready(self, call: Callable[[], None] | None) -> None:
        """Call this function whenever `ready` has changed."""
        self._call_ready = call

    def _judge(self) -> None:
        self.ready = not self._kept and self.free()

    @property
    def close_sent(self) -> bool:
        """Return whether nothing may be written any more; uvicorn sets it."""
        return self._closed

    @close_sent.setter
    def close_sent(self, closed: bool) -> None:
        self._closed = closed
        if closed:
            self.ready = False

    def when_free(self, call: Callable[[], None] | None) -> None:
        """Call this function whenever the connection becomes free again, and when it is gone."""
        self._call = call

    def pause_writing(self) -> None:
        """Note that bytes wait, and give a peer that takes nothing a limited time."""
        self._taken = self.ready = False
        self._unread = Unread(self.loop, self.transport, self._drop_unread)

    def _drop_unread(self) -> None:
        self.cause = self.cause or NOT_READ
        drop("took nothing")

    def shutdown(self) -> None:
        """End the connection because this process ends."""
        self.cause = self.cause or RESTART
        super().shutdown()

    def resume_writing(self) -> None:
        """Note that the peer has taken everything."""
        super().resume_writing()
        self._taken = True
        self._judge()
        self._look_no_more()
        if self._call is not None:
            self._call()

    def _look_no_more(self) -> None:
        if self._unread is not None:
            self._unread.cancel()
            self._unread = None

    def handle_close(self, event: Frame) -> None:
        """Receive a close; nothing is written after its answer."""
        if not self.close_sent:
            self.cause = self.cause or CLOSED_BY_PAGE
        super().handle_close(event)
        self.ready = False

    def handle_parser_exception(self) -> None:
        """End the socket because of data that is not WebSocket."""
        self._broken = True
        super().handle_parser_exception()

    async def send(self, message: Any) -> None:
        """Send for the application, which may not know yet that the peer broke the protocol."""
        if self._broken:
            raise ClientDisconnected
        await super().send(message)
        if message["type"] == "websocket.http.response.body" and not message.get("more_body", False):
            self.handshake_complete = True  # by this refusal; else uvicorn would log that there was no answer
        if not self._taken and self.transport.get_write_buffer_size() > BEFORE:
            self.writable.clear()

    def data_received(self, data: bytes) -> None:
        """Receive data; frames before the handshake is answered end the connection (RFC 6455, 4.1)."""
        if self.handshake_initiated and not self.handshake_complete:
            self.transport.abort()
            return
        super().data_received(data)
        if not self.handshake_initiated and self.conn.handshake_exc is not None and not self.transport.is_closing():
            self.transport.write(b"HTTP/1.1 400 Bad Request\r\nconnection: close\r\ncontent-length: 0\r\n\r\n")
            self.transport.close()  # uvicorn would wait for ever

    def connection_lost(self, exc: Exception | None) -> None:
        """Remove it from the count."""
        if self.counted:
            connections().leave(self.counted)
            self.counted = ""
        self.ready = False
        self._look_no_more()
        self.cause = self.cause or CUT
        super().connection_lost(exc)
        self.close_sent = True
        if self._call is not None:  # tasks that wait for it to become free must not wait for ever
            self._call()

    def handle_ping(self) -> None:
        """Answer, unless pings come too fast or nobody reads the answers."""
        if self._may():
            super().handle_ping()

    def handle_pong(self, event: Frame) -> None:
        """Receive the answer to our ping."""
        if not self._may():
            return
        if self._window is None or len(event.data) != PAYLOAD.size:
            super().handle_pong(event)
            return
        self._follow(self._window.pong(bytes(event.data), self.loop.time()))
        self._judge()
        if self._call is not None and self.free():
            self._call()

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
        within = self._frames.take(self.loop.time())
        if self.transport.get_write_buffer_size() > UNSENT:
            drop("took nothing")
            self.transport.abort()
            return False
        if not within:
            drop("sent too many frames")
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
        self.cause = self.cause or NO_PONG
        drop("answered no ping")
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
