"""Long messages in pieces, between which others are sent: bytes as u8 7, u8 flags (1 first, 2 last), bytes, and texts.

A page puts the pieces together (`frontend/src/socket/pieces.ts`). One message of each of the two at a time is in
pieces; the first piece of another drops what came of the one before.
"""

from collections.abc import Callable

from portal.live.messages import LONGEST, NotUnderstood

TYPE, FIRST, LAST = 7, 1, 2
MARK = "\x07"  # of a piece of a text
MUCH = 32  # characters or bytes that nothing compresses into one


class Pieces:
    """The message that is sent in pieces; empty once its last piece was taken."""

    def __init__(self) -> None:
        self._data, self._at = b"", 0
        self._guess = 0  # bytes of the last piece

    @property
    def left(self) -> bool:
        """Return whether pieces are left."""
        return self._at < len(self._data)

    def begin(self, data: bytes) -> None:
        """Send this message from now on."""
        self._data, self._at, self._guess = data, 0, 0

    def drop(self) -> None:
        """Send nothing more of the message."""
        self._data, self._at = b"", 0

    def take(self, most: int, size: Callable[[bytes], int] = len) -> bytes:
        """Return the next piece with its head, of at most so many bytes by `size` unless one byte has more."""
        count = _most_that_fit(len(self._data) - self._at, self._guess, most, lambda count: size(self._piece(count)))
        piece = self._piece(count)
        self._at, self._guess = self._at + count, count
        if not self.left:
            self.drop()
        return piece

    def _piece(self, count: int) -> bytes:
        end = self._at + count
        flags = (FIRST if self._at == 0 else 0) | (LAST if end == len(self._data) else 0)
        return bytes((TYPE, flags)) + self._data[self._at : end]


def _most_that_fit(left: int, before: int, most: int, size: Callable[[int], int]) -> int:
    """Return how many characters or bytes a piece has, at least one: at most twice as many as the one before.

    `size(count)`: bytes that so many take.
    """
    count = min(left, 2 * before if before else MUCH * max(most, 1))
    while (found := size(count)) > most and count > 1:
        count = max(1, min(count - 1, count * most // found))
    return count


class JoinedText:
    """Puts a long text together whose pieces a page sends, in the form of `TextPieces`."""

    def __init__(self, most: int = LONGEST) -> None:
        """`most`: characters of a text."""
        self._most = most
        self._text: str | None = None  # what has come; None: no first piece has

    def take(self, text: str) -> str | None:
        """Return a message, this one or the one that this piece ends; None: it is not whole. Raises NotUnderstood."""
        if text[:1] != MARK:
            return text
        flags = int(text[1]) if text[1:2] in ("0", "1", "2", "3") else None
        if flags is None or (self._text is None and not flags & FIRST):
            raise NotUnderstood("A piece of a message came without its first one.", hopeless=True)
        self._text = text[2:] if flags & FIRST else (self._text or "") + text[2:]
        if len(self._text) > self._most:
            raise NotUnderstood(f"A message is a JSON object of at most {self._most} bytes.", hopeless=True)
        if not flags & LAST:
            return None
        whole, self._text = self._text, None
        return whole


class TextPieces:
    """Long text messages, the newest of each kind, in pieces: U+0007, a digit (1 first, 2 last, added), the words."""

    def __init__(self) -> None:
        self._waiting: dict[str, str] = {}  # by kind
        self._text, self._at = "", 0
        self._guess = 0  # characters of the last piece

    @property
    def left(self) -> bool:
        """Return whether a text is left, or a part of one."""
        return bool(self._text or self._waiting)

    def put(self, kind: str, text: str) -> None:
        """Send this text after those that wait; one of its kind that was not begun is dropped."""
        self._waiting[kind] = text

    def take(self, most: int, size: Callable[[str], int]) -> str:
        """Return the next piece, of at most so many bytes by `size` unless one character has more.

        A text that has no more as a whole is not cut.
        """
        if not self._text:
            self._text = self._waiting.pop(next(iter(self._waiting)))
            if size(self._text) <= most:
                whole, self._text = self._text, ""
                return whole
        count = _most_that_fit(len(self._text) - self._at, self._guess, most, lambda count: size(self._piece(count)))
        piece = self._piece(count)
        self._at, self._guess = self._at + count, count
        if self._at == len(self._text):
            self._text, self._at, self._guess = "", 0, 0
        return piece

    def _piece(self, count: int) -> str:
        flags = (FIRST if self._at == 0 else 0) + (LAST if self._at + count == len(self._text) else 0)
        return f"{MARK}{flags}{self._text[self._at : self._at + count]}"
