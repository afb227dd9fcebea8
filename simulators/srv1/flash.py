"""The flash buffer and the flash memory behind it: the letters `z` and `X`."""

from binascii import crc_hqx
from collections.abc import Callable
from pathlib import Path

from simulators.srv1.xmodem import Byte, receive

BUFFER, SECTOR, CHECKED = 0x40000, 0x10000, 0x1FFF8  # bytes; `zC` leaves out the last 8 of two sectors
USER, SECTORS = 4, range(2, 64)  # the user's sector, and those that can be reached
ENDS = b"\0\x1a"  # bytes after a text: an empty buffer's, and the one with which XMODEM fills its last block


class Flash:
    """`user` outlives a loss of power; so do the other sectors while the process lives."""

    def __init__(self, user: bytes = b"") -> None:
        self._buffer = bytearray(BUFFER)
        self._sectors = {USER: user[:SECTOR]} if user else {}

    @property
    def user(self) -> bytes:
        """Return the user's sector without the zeros at its end."""
        return self._sectors.get(USER, b"").rstrip(b"\0")

    def load(self, data: bytes) -> None:
        """Replace the whole buffer."""
        self._buffer[:] = data[:BUFFER].ljust(BUFFER, b"\0")

    def text(self) -> bytes:
        """Return the text at the beginning of the buffer."""
        return text_of(bytes(self._buffer[:SECTOR]))

    def receive(self, byte: Byte, send: Callable[[bytes], None]) -> bytes:
        """Do `X`: receive the buffer's contents; return the answer. An interruption leaves the buffer empty."""
        self.load(b"")
        data, count = receive(byte, send, BUFFER)
        self.load(data)
        if count < 0:
            return b"##Xmodem receive error: %d\r\n" % count
        return b"##Xmodem success. Count: %d\r\n" % count

    def do(self, argument: Callable[[], int]) -> bytes:
        """Do `z` with the letter that follows; return the answer."""
        letter = chr(argument())
        if letter in "ABRW":
            return self._sector(letter, (argument() & 15) * 10 + (argument() & 15))
        if letter == "r":
            self._buffer[:SECTOR] = self._stored(USER, SECTOR)
            return b"##zread count: %d\r\n" % SECTOR
        if letter == "w":
            self._store(USER, SECTOR)
            return b"##zwrite count: %d\r\n" % SECTOR
        if letter == "c":
            self.load(b"")
            return b"##zclear buffer\r\n"
        if letter == "C":
            return b"##zCRC: 0x%x\r\n" % crc_hqx(bytes(self._buffer[:CHECKED]), 0)
        if letter == "d":
            end = self._buffer.find(b"\0", 0, SECTOR)
            shown = bytes(self._buffer[: end if end >= 0 else SECTOR])
            return b"##zdump: \r\n" + shown.replace(b"\n", b"\r\n")
        if letter == "h":
            return b"##zhttp: \r\n"
        return b"##zZ boot image - invalid header\r\n" if letter == "Z" else b""

    def _sector(self, letter: str, number: int) -> bytes:
        size = 2 * SECTOR if letter in "AB" else SECTOR
        head = {"A": b"##zA ", "B": b"##zB ", "R": b"##zRead ", "W": b"##zWrite "}[letter]
        if letter in "AR":
            self._buffer[:size] = bytes(size)
        if number not in SECTORS:
            return head + b" - sector %d not accessible\r\n" % number
        where = (b"s %d->%d" % (number, number + 1)) if letter in "AB" else b" %d" % number
        if letter in "AR":
            self._buffer[:size] = self._stored(number, size)
            where = where if letter == "R" else where[1:]
            return head + b" - loaded %d bytes from flash sector%b\r\n" % (size, where)
        self._store(number, size)
        return head + b" - saved %d bytes to flash sector%b\r\n" % (size, where)

    def _stored(self, number: int, size: int) -> bytes:
        sectors = (self._sectors.get(n, b"").ljust(SECTOR, b"\0") for n in range(number, number + size // SECTOR))
        return b"".join(sectors)

    def _store(self, number: int, size: int) -> None:
        for at in range(0, size, SECTOR):
            self._sectors[number + at // SECTOR] = bytes(self._buffer[at : at + SECTOR])


def text_of(data: bytes) -> bytes:
    """Return the text at the beginning of the data."""
    ends = (at for at in (data.find(end) for end in (ENDS[:1], ENDS[1:])) if at >= 0)
    return data[: min(ends, default=len(data))]


def restore_user(path: Path) -> bytes:
    """Return the user's sector that was stored in `path`; nothing if that cannot be read."""
    try:
        return path.read_bytes()[:SECTOR]
    except OSError:
        return b""
