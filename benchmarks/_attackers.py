"""A crowd of strangers in a process of its own, over raw connections: `python -m benchmarks._attackers CROWD PORT`.

Prints a line once it attacks, and ends with its standard input. It has the lowest priority, as
strangers' machines take no processor time from ours.
"""

import asyncio
import os
import sys
from collections.abc import Awaitable, Callable
from contextlib import suppress

GET = b"GET %s HTTP/1.1\r\nHost: localhost\r\n\r\n"
POST = b"POST /accounts/login/ HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
CHUNK = 65536
PAUSE_S = 0.05  # after a refused connection

Attack = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


async def pages(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Fetch an ordinary page again and again."""
    while True:
        writer.write(GET % b"/log/?q=sand&page=1")
        head = await reader.readuntil(b"\r\n\r\n")
        sizes = [line for line in head.lower().split(b"\r\n") if line.startswith(b"content-length:")]
        if sizes:
            await reader.readexactly(int(sizes[0].split(b":")[1]))
        else:
            await reader.readuntil(b"0\r\n\r\n")


async def trailers(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Send a body whose trailers never end."""
    writer.write(POST + b"0\r\n")
    while True:
        writer.write(b"X-A: " + b"b" * 1000 + b"\r\n")
        await writer.drain()


async def pieces(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Send a body in chunks of one byte."""
    writer.write(POST)
    while True:
        writer.write(b"1\r\nx\r\n" * 1000)
        await writer.drain()


async def pipelining(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Ask without end, and never read an answer."""
    while True:
        writer.write(GET % b"/" * 500)
        await writer.drain()


async def malformed(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Send what is no request; or one for a foreign host with control characters in its address."""
    writer.write(b"GET /%0d%1b[31m" + b"%0d" * 2000 + b" HTTP/1.1\r\nHost: evil.example\r\nHost: two\r\n\r\n")
    await reader.read(CHUNK)
    writer.write(b"\x16\x03\x01 GET\r\n\r\n" * 100)
    await reader.read(CHUNK)


CROWDS: dict[str, tuple[Attack, int]] = {  # and how many connections
    "pages": (pages, 100), "more_pages": (pages, 280), "trailers": (trailers, 20), "pieces": (pieces, 50),
    "pipelining": (pipelining, 200), "malformed": (malformed, 50),
}  # fmt: skip


async def attack(port: int, how: Attack) -> None:
    """Attack over one connection after another."""
    while True:
        with suppress(OSError, EOFError, asyncio.LimitOverrunError, ValueError):
            reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=2**20)
            try:
                if how is not pages:
                    writer.transport.set_write_buffer_limits(high=CHUNK)
                if how in (pipelining, trailers, pieces):
                    reader._transport.pause_reading()  # type: ignore[attr-defined]
                await how(reader, writer)
            finally:
                writer.transport.abort()
        await asyncio.sleep(PAUSE_S)


async def main() -> None:
    """Attack until the standard input ends."""
    how, connections = CROWDS[sys.argv[1]]
    os.nice(19)
    tasks = [asyncio.create_task(attack(int(sys.argv[2]), how)) for _ in range(connections)]
    print("begun", flush=True)
    await asyncio.to_thread(sys.stdin.read)
    for task in tasks:
        task.cancel()


if __name__ == "__main__":
    asyncio.run(main())
