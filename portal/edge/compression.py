"""The compression of messages (permessage-deflate, RFC 7692).

A message is compressed by itself, so that it is compressed once for all and an idle connection keeps no compressor.
Over a thin line each message is compressed against those before it instead: a snapshot that repeats the last one but
for a few words takes some dozen bytes. The peer keeps its window anyway; here the newest messages are kept in place of
a compressor.
"""

import zlib
from collections.abc import Sequence
from functools import lru_cache

from websockets.extensions.permessage_deflate import PerMessageDeflate, ServerPerMessageDeflateFactory
from websockets.frames import Frame, Opcode
from websockets.typing import ExtensionParameter

BITS, SETTINGS = 12, {"memLevel": 5}  # the window and memory of a compressor of one message
TEXTS = 128  # frames that are kept, of the newest messages
SMALL = 200  # bytes of a text that is not worth compressing by itself
HISTORY = 1 << 14  # bytes of the newest messages that are kept of a thin line
END = b"\x00\x00\xff\xff"  # of a flush, which is not sent


class Deflate(PerMessageDeflate):
    """The compression of one connection: each message by itself, or, while it remembers, against those before it."""

    def __init__(self, agreed: PerMessageDeflate) -> None:
        self._bits = agreed.local_max_window_bits
        bits, theirs = min(BITS, self._bits), agreed.remote_max_window_bits
        super().__init__(agreed.remote_no_context_takeover, True, theirs, bits, SETTINGS)
        self.may_remember = not agreed.local_no_context_takeover
        self._history: bytes | None = None

    def remember(self, on: bool) -> None:
        """Compress messages against those that are sent from now on, or texts each by itself again."""
        if on != self.remembers:
            self._history = b"" if on and self.may_remember else None

    @property
    def remembers(self) -> bool:
        """Return whether each message is compressed against those before: every compressed one has to pass here."""
        return self._history is not None

    def size(self, data: bytes) -> int:
        """Return how many bytes a message would take as the next one."""
        return min(len(data), len(self._deflated(data)))

    def encode(self, frame: Frame) -> Frame:
        """Return the frame of a message compressed, unless that is longer; control frames stay as they are."""
        if self._history is None or frame.opcode not in (Opcode.TEXT, Opcode.BINARY) or not frame.fin:
            if self._history is not None and frame.opcode in (Opcode.TEXT, Opcode.BINARY, Opcode.CONT):
                self._history = b""  # what the peer's window ends with is not known any more
            return super().encode(frame)
        whole = bytes(frame.data)
        data = self._deflated(whole)
        if len(data) >= len(whole):
            return frame  # it does not get into the peer's window
        self._history = (self._history + whole)[-HISTORY:]
        return Frame(frame.opcode, data, True, True, frame.rsv2, frame.rsv3)

    def _deflated(self, whole: bytes) -> bytes:
        known = (self._history or b"")[-(1 << self._bits) :]
        more = {"zdict": known} if known else {}
        coder = zlib.compressobj(wbits=-self._bits, **more)  # type: ignore[arg-type]
        return (coder.compress(whole) + coder.flush(zlib.Z_SYNC_FLUSH)).removesuffix(END)


class _Factory(ServerPerMessageDeflateFactory):
    """Agrees on the compression; the peer keeps its window unless it has asked not to."""

    def process_request_params(
        self, params: Sequence[ExtensionParameter], accepted_extensions: Sequence[object]
    ) -> tuple[list[ExtensionParameter], Deflate]:
        """Return what is agreed on, and the compression."""
        agreed, made = super().process_request_params(params, accepted_extensions)  # type: ignore[arg-type]
        return agreed, Deflate(made)


DEFLATE = _Factory(False, True, None, BITS)


@lru_cache(TEXTS)
def text_frames(text: str) -> tuple[bytes, bytes]:
    """Return the frame of a text message, plain and compressed by itself; the same objects for the same message."""
    frame = Frame(Opcode.TEXT, text.encode())
    plain = frame.serialize(mask=False)
    if len(text) < SMALL:
        return plain, plain
    return plain, frame.serialize(mask=False, extensions=[PerMessageDeflate(True, True, BITS, BITS, SETTINGS)])


def suits(extension: object) -> bool:
    """Return whether a connection with this extension reads what `text_frames` compresses."""
    return isinstance(extension, PerMessageDeflate) and extension.local_max_window_bits >= BITS
