"""WebSocket frames that are made once and written to many connections.

A server that can do so offers its connection to the application under `NAME` in the extensions of the ASGI scope;
under any other server everything goes through the ordinary `send`.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, Protocol

from websockets.frames import Frame, Opcode

NAME = "farhand.connection"
PICTURES = 16  # frames that are kept, of the newest messages


class Connection(Protocol):
    """A connection to which whole frames may be written."""

    deflates: bool  # a message compressed by `text_frames` suits it
    ready: bool  # a frame may be written at once: it is free, and nothing waits before it
    cause: str  # why it ended; empty while it is open

    def free(self) -> bool:
        """Return whether it is open, and everything written before has been taken by the network, or by the peer."""

    def is_closing(self) -> bool:
        """Return whether nothing can be written any more."""

    def keep(self, waits: bool) -> None:
        """Note whether something waits that comes before any frame; while it does, the connection is not `ready`."""

    def write(self, frame: bytes) -> None:
        """Write a whole frame."""

    def bound(self, on: bool) -> None:
        """Let no more be on the way than a thin line carries in a moment, or no longer; `free` and `ready` follow."""

    def remember(self, on: bool) -> None:
        """Compress messages against those before from now on, or texts each by itself again."""

    def frame(self, message: str | bytes) -> bytes:
        """Return the frame of a message for this connection alone, which has to be written next."""

    def size(self, message: str | bytes) -> int:
        """Return how many bytes it would take."""

    @property
    def window(self) -> int:
        """Return how many bytes may be on the way; 0: any number."""

    def when_ready(self, call: Callable[[], None] | None) -> None:
        """Call this function whenever `ready` has changed."""

    def when_free(self, call: Callable[[], None] | None) -> None:
        """Call this function whenever the connection becomes free again, and when it is gone."""


def connection_of(scope: dict[str, Any]) -> Connection | None:
    """Return the connection of a socket; None if the server does not offer it."""
    offered: Connection | None = scope.get("extensions", {}).get(NAME, {}).get("connection")
    return offered


@lru_cache(PICTURES)
def binary_frame(data: bytes) -> bytes:
    """Return the frame of a binary message; the same object for the same message."""
    return Frame(Opcode.BINARY, data).serialize(mask=False)
