"""A long binary message in pieces, between which other messages are sent: u8 7, u8 flags (1 first, 2 last), bytes.

A page puts the pieces together (`frontend/src/socket/pieces.ts`). One message at a time is in pieces; the first piece
of another drops what came of the one before.
"""

TYPE, FIRST, LAST = 7, 1, 2


class Pieces:
    """The message that is sent in pieces; empty once its last piece was taken."""

    def __init__(self) -> None:
        self._data, self._at = b"", 0

    @property
    def left(self) -> bool:
        """Return whether pieces are left."""
        return self._at < len(self._data)

    def begin(self, data: bytes) -> None:
        """Send this message from now on."""
        self._data, self._at = data, 0

    def drop(self) -> None:
        """Send nothing more of the message."""
        self._data, self._at = b"", 0

    def take(self, most: int) -> bytes:
        """Return the next piece, of at most so many bytes (3 or more) with its head."""
        end = min(self._at + max(most, 3) - 2, len(self._data))
        flags = (FIRST if self._at == 0 else 0) | (LAST if end == len(self._data) else 0)
        piece = bytes((TYPE, flags)) + self._data[self._at : end]
        self._at = end
        if not self.left:
            self.drop()
        return piece
