"""Reads the file of a recording as far as it goes: whole, cut off anywhere, damaged, or no recording at all.

Nothing here raises for what a file contains. A chunk that is damaged is left out; its checksum tells. No Django.
"""

import struct
from collections.abc import Container, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import IO
from zlib import crc32
from zlib import error as ZlibError

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, Metadata
from mcap.records import Message as Record
from mcap.stream_reader import breakup_chunk

from robots.kit.recording.container import Message

TORN = (
    McapError,
    ValueError,
    struct.error,
    zstandard.ZstdError,
    ZlibError,
    EOFError,
    KeyError,
    IndexError,
    MemoryError,
    OverflowError,
)
HEAD = struct.Struct("<BQ")  # of each record: what it is, and its length
FOOTER = struct.Struct("<BQQQI")  # its head; where the summary begins, and its offsets; the checksum of all before it
MAGIC = 8  # bytes
LARGEST = 64_000_000  # bytes of a chunk
BEFORE_END = frozenset({Opcode.HEADER, Opcode.MESSAGE_INDEX, Opcode.METADATA, Opcode.ATTACHMENT})
CUT = "The file was cut off here."
DAMAGED = "The file is damaged from here on."
LEFT_OUT = "A part that is damaged is left out here."
NOTHING = "There is nothing in the file."


@dataclass(frozen=True)
class Part:
    """A chunk: where it is in the file, and its messages. `fault`: why it has none, or nothing follows, in words."""

    offset: int
    messages: tuple[Message, ...] = ()
    fault: str = ""


def parts(path: Path, offset: int = 0, topics: dict[int, str] | None = None) -> Iterator[Part]:
    """Yield the chunks of a file in their order, from the one at `offset` on. Raises OSError.

    `topics`: those of channels that are known already; what the file says of others is added.
    """
    topics = {} if topics is None else topics
    with path.open("rb") as file:
        size = file.seek(0, 2)
        chunks = _summary(file, topics)
        if chunks is None:
            yield from _walked(file, size, max(offset, MAGIC), topics)
            return
        for at in chunks:
            if at >= offset:
                yield _part(file, size, at, topics)


def messages(path: Path, topics: Container[str] | None = None) -> Iterator[Message]:
    """Yield all messages that can be read, in the order of the file, or those of some topics. Raises OSError."""
    for part in parts(path):
        yield from (one for one in part.messages if topics is None or one.topic in topics)


def about(path: Path) -> dict[str, str]:
    """Return the file's metadata: robot, driver, kind; empty where they are damaged. Raises OSError."""
    with path.open("rb") as file:
        size, at = file.seek(0, 2), MAGIC
        while (head := _head(file, size, at)) is not None:
            what, length = head
            if what == Opcode.METADATA:
                try:
                    return dict(Metadata.read(ReadDataStream(BytesIO(file.read(length)))).metadata)
                except TORN:
                    return {}
            if what != Opcode.HEADER:
                return {}
            at += HEAD.size + length
    return {}


def _summary(file: IO[bytes], topics: dict[int, str]) -> list[int] | None:
    """Return where the chunks are, None if the file does not say so; take in the topics of its channels."""
    try:
        file.seek(-FOOTER.size - MAGIC, 2)
        *_, begin, _, checksum = FOOTER.unpack(file.read(FOOTER.size))
        file.seek(begin)
        if crc32(file.read()[: -4 - MAGIC]) != checksum:
            return None
        file.seek(0)
        summary = SeekingReader(file, record_size_limit=LARGEST).get_summary()
    except (*TORN, OSError):
        return None
    if summary is None or summary.statistics is None or summary.statistics.chunk_count != len(summary.chunk_indexes):
        return None
    topics |= {number: channel.topic for number, channel in summary.channels.items()}
    return sorted(one.chunk_start_offset for one in summary.chunk_indexes)


def _head(file: IO[bytes], size: int, at: int) -> tuple[int, int] | None:
    """Return the kind and the length of the record at a place, and read its head; None if the record is not whole."""
    if at + HEAD.size > size:
        return None
    file.seek(at)
    what, length = HEAD.unpack(file.read(HEAD.size))
    return (what, length) if at + HEAD.size + length <= size else None


def _walked(file: IO[bytes], size: int, at: int, topics: dict[int, str]) -> Iterator[Part]:
    """Yield the chunks of a file that does not say where they are, one after the other."""
    while True:
        head = _head(file, size, at)
        if head is None:
            yield Part(at, fault=CUT)
            return
        what, length = head
        if what == Opcode.DATA_END:
            return
        if what == Opcode.CHUNK:
            yield _part(file, size, at, topics)
        elif what not in BEFORE_END:
            yield Part(at, fault=DAMAGED)
            return
        at += HEAD.size + length


def _part(file: IO[bytes], size: int, at: int, topics: dict[int, str]) -> Part:
    """Return the chunk at a place; topics that it names are known from now on."""
    head = _head(file, size, at)
    if head is None or head[0] != Opcode.CHUNK or head[1] > LARGEST:
        return Part(at, fault=LEFT_OUT)
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(file.read(head[1]))))
        if not _bounded(chunk):
            return Part(at, fault=LEFT_OUT)
        records = breakup_chunk(chunk, validate_crc=True)
    except TORN:
        return Part(at, fault=LEFT_OUT)
    topics |= {record.id: record.topic for record in records if isinstance(record, Channel)}
    known = [record for record in records if isinstance(record, Record)]
    found = tuple(
        Message(topics[one.channel_id], one.log_time, one.publish_time, one.data)
        for one in known
        if one.channel_id in topics
    )
    return Part(at, found, "" if len(found) == len(known) else LEFT_OUT)


def _bounded(chunk: Chunk) -> bool:
    """Tell whether a chunk takes no more memory than it declares, and declares no more than `LARGEST`."""
    if not 0 < chunk.uncompressed_size <= LARGEST:
        return False
    return chunk.compression != "zstd" or zstandard.frame_content_size(chunk.data) in (-1, chunk.uncompressed_size)
