"""The receiving end of XMODEM as the firmware has it (`xmodem.c`): 128 or 1024 bytes a block, with CRC or checksum.

A byte of value 0 counts as silence, so after a bad block bytes are dropped until a 0, or until 1 s of silence.
"""

from binascii import crc_hqx
from collections.abc import Callable

SOH, STX, EOT, ACK, NAK, CAN = 0x01, 0x02, 0x04, 0x06, 0x15, 0x18
BLOCK = {SOH: 128, STX: 1024}
WAIT_S, TRIES, RETRIES = 1.0, 30, 25
CANCELLED, NO_SENDER, TOO_MANY = -1, -2, -3

Byte = Callable[[float], int | None]


def _in(byte: Byte) -> int:
    return byte(WAIT_S) or 0


def _flush(byte: Byte) -> None:
    while _in(byte):
        pass


def _is_right(block: bytes, check: bytes) -> bool:
    if len(check) == 2:
        return crc_hqx(block, 0) == int.from_bytes(check, "big")
    return sum(block) & 0xFF == check[0]


def receive(byte: Byte, send: Callable[[bytes], None], room: int) -> tuple[bytes, int]:
    """Receive a file; return its bytes, at most `room`, and the length that is answered, or a negative error.

    `byte(seconds)` waits for a byte; what it raises ends the reception.
    """
    received = bytearray()
    with_crc, expected, tries = False, 1, RETRIES
    asking: int | None = ord("C")
    while True:
        first = _start(byte, send, asking)
        if first is None:
            if asking == ord("C"):
                asking = NAK
                continue
            _flush(byte)
            send(bytes((CAN,) * 3))
            return bytes(received), NO_SENDER
        if first in (EOT, CAN):
            _flush(byte)
            send(bytes((ACK,)))
            return bytes(received), len(received) if first == EOT else CANCELLED
        with_crc, asking = with_crc or asking == ord("C"), None
        size = BLOCK[first]
        packet = bytes(_in(byte) for _ in range(2 + size + (2 if with_crc else 1)))
        number, inverse, block, check = packet[0], packet[1], packet[2 : 2 + size], packet[2 + size :]
        if number != 255 - inverse or number not in (expected, (expected - 1) % 256) or not _is_right(block, check):
            _flush(byte)
            send(bytes((NAK,)))
            continue
        if number == expected:
            received += block[: max(0, room - len(received))]
            expected, tries = (expected + 1) % 256, RETRIES + 1
        tries -= 1
        if tries <= 0:
            _flush(byte)
            send(bytes((CAN,) * 3))
            return bytes(received), TOO_MANY
        send(bytes((ACK,)))


def _start(byte: Byte, send: Callable[[bytes], None], asking: int | None) -> int | None:
    """Wait for a byte that begins a block or ends the transfer; return None if none comes within 30 tries."""
    for _ in range(TRIES):
        if asking is not None:
            send(bytes((asking,)))
        first = _in(byte)
        if first in BLOCK or first == EOT or (first == CAN and _in(byte) == CAN):
            return first
    return None
