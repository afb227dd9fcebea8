"""A text into the rover's flash buffer: `X`, then XMODEM with blocks of 128 bytes and a CRC.

Each byte is sent only right after one that only an open reception sends (`C`, ACK, NAK), because every other reader of
these bytes takes letters of the text for commands. After silence nothing is resent; the whole text may be sent anew.
"""

from binascii import crc_hqx
from collections.abc import Callable

from robots.kit.drivers.srv1.protocol import RECEIVE

SOH, EOT, ACK, NAK, CAN, ASKS = b"\x01", b"\x04", b"\x06", b"\x15", b"\x18", b"C"
BLOCK, LARGE = 128, 1024  # bytes
FILL = b"\x1a"  # the last block's rest, where text ends
TRIES = 4  # of a block
CHECKED = 0x1FFF8  # bytes of the buffer that `zC` sums up; those not received are 0
# The firmware throws bytes away after the end and after a block that is wrong, until one is 0 or for 1 s of silence.
QUIET = b"\0"
# Ends a reception at any point: 01 begins a block or fills one that is open, and is harmless to every other reader
# (protocol.RESYNCHRONISE). Only then come 00 and CAN, which a command that was cut off must not take.
END = SOH * (BLOCK + 5) + QUIET + CAN * 2 + QUIET
END_OF_ANY = SOH * (LARGE + 5) + QUIET + CAN * 2 + QUIET  # also of a client that sends large blocks

Exchange = Callable[[bytes], bytes]  # sends bytes and returns the next one that comes; raises TimeoutError


class OutOfStep(TimeoutError):
    """The rover's answer is none that a receiver of blocks gives."""


def blocks(data: bytes) -> list[bytes]:
    """Return the blocks of a transfer, counted from 1; the last one is filled."""
    pieces = (data[at : at + BLOCK].ljust(BLOCK, FILL) for at in range(0, len(data), BLOCK))
    return [
        SOH + bytes((n & 0xFF, 0xFF - (n & 0xFF))) + piece + crc_hqx(piece, 0).to_bytes(2, "big")
        for n, piece in enumerate(pieces, 1)
    ]


def buffer_crc(data: bytes) -> int:
    """Return what `zC` says once `data` was received into the empty buffer."""
    filled = data.ljust(-(-len(data) // BLOCK) * BLOCK, FILL)
    return crc_hqx(filled[:CHECKED].ljust(CHECKED, b"\0"), 0)


def send(data: bytes, exchange: Exchange) -> None:
    """Send all of it; the rover's line with the count has still to be read. Raises OutOfStep, and what `exchange` does.

    After an error the reception may be open; `END` ends it.
    """
    if exchange(RECEIVE) != ASKS:
        raise OutOfStep("the rover does not receive")
    for block in blocks(data):
        for _ in range(TRIES):
            said = exchange(block + QUIET)
            while said == ASKS:  # the rover asked once more before the first block came
                said = exchange(b"")
            if said != NAK:
                break
        if said != ACK:
            raise OutOfStep(f"the rover answers {said!r} to a block")
    if exchange(EOT + QUIET) != ACK:
        raise OutOfStep("the rover does not confirm the end")
