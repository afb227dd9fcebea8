"""Writes the messages in a viewer's mailbox to its connection, each when all before it were taken."""

import asyncio
from collections.abc import Awaitable, Callable

import msgspec

from portal.edge.direct import binary_frame
from portal.live.hub import Hub
from portal.live.viewer import Viewer
from portal.live.watchers import watchers_text
from robots.kit.packets import Changed

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

    async def run(self) -> None:
        """Send the messages in the mailbox; while Redis is away, ask for a snapshot every second."""
        while True:
            await self._viewer.wait_for_mail(IDLE_S if self._hub.link else UNLINKED_S)
            if not self._hub.link:
                self._outdated.set()
            await self._empty(self._viewer)

    async def _empty(self, viewer: Viewer) -> None:
        """Send everything in the mailbox, the newest of each kind; pictures of several cameras in turns."""
        sent = True
        while viewer.take_signal() or sent:
            await self.wait_until_free()
            snapshot, count = viewer.take_requests()
            if snapshot:
                self._outdated.set()
            sent = count
            if (state := viewer.take_state()) is not None:
                sent = True
                await self.send_bytes(state)
            if (path := viewer.take_path()) is not None:
                sent = True
                await self.send_bytes(path)
            for data in (*viewer.take_sounds(), *self._hub.news(viewer)):
                sent = True
                await self.send_bytes(data)
            while (event := viewer.take_event()) is not None:
                sent = True
                if isinstance(event, Changed):
                    self._outdated.set()
                else:
                    await self.send_text(msgspec.json.encode(event).decode())
            if count:
                await self.send_text(watchers_text(self._hub.watchers(viewer.slug)))
            await self.wait_until_free()
            if packets := self._hub.video(viewer):
                sent = True
                await self._send_together(packets)
            if (picture := viewer.take_picture()) is not None:
                sent = True
                await self.send_bytes(picture)
        viewer.set_empty()

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
        """Send a binary message."""
        await self.wait_until_free()
        if self._connection is None:
            await self._send(bytes_data=data)
        elif not self._connection.is_closing():
            self._viewer.write(binary_frame(data))

    async def send_text(self, text: str) -> None:
        """Send a text message."""
        await self.wait_until_free()
        if self._connection is None:
            await self._send(text)
        elif not self._connection.is_closing():
            self._viewer.write_text(text)

    async def _send_together(self, packets: list[bytes]) -> None:
        """Send several messages, over a connection in one go: later messages wait behind them."""
        if self._connection is None:
            for packet in packets:
                await self._send(bytes_data=packet)
        elif not self._connection.is_closing():
            self._viewer.write(b"".join(map(binary_frame, packets)))
