"""Writes the messages in a viewer's mailbox to its connection, each when all before it were taken."""

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable

import msgspec

from portal.edge.direct import binary_frame
from portal.live.hub import Hub
from portal.live.pieces import MUCH, Pieces, TextPieces
from portal.live.viewer import Viewer
from portal.live.watchers import watchers_text
from robots.kit.contract.short_heads import ShortHeads
from robots.kit.contract.streams import unpack
from robots.kit.packets import Changed

LARGEST = 1 << 30  # bytes of a piece once the line is thin no longer: all that is left
UNLINKED_S = 1.0  # between two snapshots while Redis is away
IDLE_S = 15.0  # between two looks into a mailbox that nobody has filled


class Writer:
    """The writer of one viewer; `send` sends a message where the server does not offer the connection.

    It sets `outdated` when a new snapshot is needed.
    """

    def __init__(
        self, viewer: Viewer, send: Callable[..., Awaitable[None]], outdated: asyncio.Event, hub: Hub
    ) -> None:  # fmt: skip
        self._hub = hub
        self._viewer, self._connection, self._send, self._outdated = viewer, viewer.connection, send, outdated
        self.freed = asyncio.Event()  # set whenever the connection has taken everything
        self._one_by_one = asyncio.Lock()
        self._waiting: dict[int, deque[bytes]] = {}  # packets of each byte stream; the stream sent last comes last
        self._pieces = Pieces()  # of a long message
        self._stream: int | None = None  # whose packet it is
        self._picture = False  # it is a picture
        self._heads, self._texts = ShortHeads(), TextPieces()
        self._told = asyncio.Event()  # set while no text is left
        self._told.set()
        self._counts = False  # the number of watchers is to be sent

    async def run(self) -> None:
        """Send the messages in the mailbox; while Redis is away, ask for a snapshot every second."""
        while True:
            await self._viewer.wait_for_mail(IDLE_S if self._hub.link else UNLINKED_S)
            if not self._hub.link:
                self._outdated.set()
            await self._empty(self._viewer)

    async def _empty(self, viewer: Viewer) -> None:
        """Send everything in the mailbox, the newest of each kind, the most important first, in rounds.

        Before each message the path and the events are sent that have come meanwhile. A round has the newest state,
        what has come of sound and byte streams, then texts and pictures, of several cameras in turns. Of what is long
        over a thin line it has one piece, so that no state waits for more than that.
        """
        steps = (
            self._requests,
            self._state,
            self._sound,
            self._packets,
            self._count,
            self._text,
            self._long,
            self._pictures,
        )
        sent = True
        while viewer.take_signal() or sent:
            sent = False
            for step in steps:
                sent = await self._urgent(viewer) or sent
                sent = await step(viewer) or sent
        viewer.set_empty()

    async def _urgent(self, viewer: Viewer) -> bool:
        """Send the path and the events that wait, and return once the connection is free; whether there was one."""
        await self.wait_until_free()
        found = await self._path(viewer)  # a path says soonest what a command does
        if found:
            await self.wait_until_free()
        while (event := viewer.take_event()) is not None:
            found = True
            if isinstance(event, Changed):
                self._outdated.set()
            else:
                await self.send_message(msgspec.json.encode(event).decode())
            await self.wait_until_free()
        return found

    async def _state(self, viewer: Viewer) -> bool:
        return await self._send_if(viewer.take_state())

    async def _path(self, viewer: Viewer) -> bool:
        return await self._send_if(viewer.take_path())

    async def _sound(self, viewer: Viewer) -> bool:
        sounds = viewer.take_sounds()
        for data in sounds:
            await self.send_bytes(data)
        return bool(sounds)

    async def _packets(self, viewer: Viewer) -> bool:
        """Send the packets of byte streams; over a thin line one, of the streams in turn.

        A long one is begun. While one is in pieces, the others of its stream wait for its end, and other long ones.
        """
        for data in self._hub.news(viewer):
            packet = unpack(data)
            waiting = self._waiting.setdefault(packet.stream, deque())
            if packet.key:
                waiting.clear()  # it has everything
            waiting.append(data)
        found = False
        while (stream := self._next_stream(viewer)) is not None:
            found = True
            waiting = self._waiting.pop(stream)
            data = self._heads.shorten(waiting.popleft()) if viewer.piece else waiting.popleft()
            if waiting:
                self._waiting[stream] = waiting
            if not self._pieces.left and self._is_long(viewer, data):
                self._begin(data, stream)
            else:
                await self.send_message(data)
            if viewer.piece:
                break
        return found

    def _next_stream(self, viewer: Viewer) -> int | None:
        """Return the byte stream whose next packet may be sent now."""
        for stream, waiting in self._waiting.items():
            if not self._pieces.left or (stream != self._stream and not self._is_long(viewer, waiting[0])):
                return stream
        return None

    def _is_long(self, viewer: Viewer, data: bytes) -> bool:
        """Return whether a packet is sent in pieces, without compressing one of which that is plain."""
        if not viewer.piece or len(data) <= viewer.piece:
            return False
        return len(data) > MUCH * viewer.piece or viewer.size(data) > viewer.piece

    async def _requests(self, viewer: Viewer) -> bool:
        snapshot, count = viewer.take_requests()
        self._counts = self._counts or count
        if snapshot:
            self._outdated.set()
        return False

    async def _count(self, viewer: Viewer) -> bool:
        counts, self._counts = self._counts, False
        if counts:
            await self.send_message(watchers_text(self._hub.watchers(viewer.slug)))
            if cheers := self._hub.cheers(viewer.slug).text():
                await self.send_message(cheers)
        return counts

    async def _text(self, viewer: Viewer) -> bool:
        """Send the next piece of a long text."""
        if not self._texts.left:
            return False
        await self.send_message(self._texts.take(viewer.piece or LARGEST, viewer.size))
        if not self._texts.left:
            self._told.set()
        return True

    async def tell(self, kind: str, text: str, shared: bool = False) -> None:
        """Send a long text; over a thin line in pieces later, if none of its kind comes before it is begun.

        `shared`: others get the same one, so that it is compressed once; it waits until the connection is free.
        """
        if not self._viewer.piece and not self._texts.left:
            await (self.send_message(text) if shared else self._send(text))
            return
        self._texts.put(kind, text)
        self._told.clear()
        self._viewer.wake()

    async def wait_until_told(self) -> None:
        """Wait until all long texts were written, or the connection is gone."""
        await self._told.wait()

    async def _long(self, viewer: Viewer) -> bool:
        """Send the next piece of what is in pieces; what is no packet of a stream waits for texts."""
        if self._texts.left and self._stream is None:
            return False
        if self._pieces.left and self._picture and not viewer.wish.cameras:
            self._pieces.drop()  # nobody looks at this picture any more
        if not self._pieces.left:
            return False
        if self._stream is None:
            await self.send_bytes(self._pieces.take(viewer.piece or LARGEST))
        else:
            await self.send_message(self._pieces.take(viewer.piece or LARGEST, viewer.size))
        return True

    async def _pictures(self, viewer: Viewer) -> bool:
        if self._pieces.left or self._texts.left:
            return False
        if (whole := viewer.take_whole()) is not None:
            self._begin(whole)
            return await self._long(viewer)
        packets = self._hub.video(viewer)
        if packets:
            await self._send_together(packets)
        picture = viewer.take_picture()
        if picture is None:
            return bool(packets)
        if viewer.piece and len(picture) > viewer.piece:
            self._begin(picture, picture=True)
        else:
            await self.send_bytes(picture)
        return True

    def _begin(self, data: bytes, stream: int | None = None, picture: bool = False) -> None:
        """Send a message in pieces; `stream`: whose packet it is."""
        self._pieces.begin(data)
        self._stream, self._picture = stream, picture

    async def _send_if(self, data: bytes | None) -> bool:
        if data is not None:
            await self.send_bytes(data)
        return data is not None

    async def wait_until_free(self) -> None:
        """Wait until the connection has taken everything, or is gone; newer messages replace older ones meanwhile.

        Callers are served in order, so that on a slow line pictures do not delay snapshots for ever.
        """
        connection = self._connection
        if connection is None or (connection.free() and not self._one_by_one.locked()):
            return
        async with self._one_by_one:
            while not connection.free() and not connection.is_closing():
                self.freed.clear()
                await self.freed.wait()

    async def send_bytes(self, data: bytes) -> None:
        """Send bytes as they are: pictures, states and sound are as short as they get."""
        await self.wait_until_free()
        if self._connection is None:
            await self._send(bytes_data=data)
        elif not self._connection.is_closing():
            self._viewer.write(binary_frame(data))

    async def send_message(self, message: str | bytes) -> None:
        """Send a text, or bytes that may be compressed over a thin line."""
        await self.wait_until_free()
        if self._connection is None:
            await (self._send(message) if isinstance(message, str) else self._send(bytes_data=message))
        elif not self._connection.is_closing():
            self._viewer.write_message(message)

    async def _send_together(self, packets: list[bytes]) -> None:
        """Send several messages, over a connection in one go: later messages wait behind them."""
        if self._connection is None:
            for packet in packets:
                await self._send(bytes_data=packet)
        elif not self._connection.is_closing():
            self._viewer.write(b"".join(map(binary_frame, packets)))
