"""Serves beside other work of the same process, on a port that may be taken when it starts."""

import asyncio
import errno
import socket
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any

import uvicorn

AGAIN_S, BACKLOG = 5.0, 512  # between two tries to have a port; connections that may wait to be taken


async def listener(host: str, port: int, other: str, tell: Callable[[str], None]) -> socket.socket:
    """Return a socket that listens there. While that cannot be, say why, once, and `other`, the setting; try again."""
    told, family = False, socket.AF_INET6 if ":" in host else socket.AF_INET
    while True:
        try:
            return socket.create_server((host, port), family=family, backlog=BACKLOG)
        except OSError as error:
            if not told:
                taken = error.errno == errno.EADDRINUSE
                why = "is taken: stop the other process" if taken else f"cannot be used ({error.strerror})"
                tell(f"Port {port} on {host} {why}, or choose another by {other}. It is tried every {AGAIN_S:g} s.")
            told = True
        await asyncio.sleep(AGAIN_S)


async def beside(served: uvicorn.Config, line: socket.socket, work: Coroutine[Any, Any, None]) -> None:
    """Serve on a socket that listens while this work goes on, until stopped. Raises what ends the work."""
    server = uvicorn.Server(served)
    serving, working = asyncio.create_task(server.serve([line])), asyncio.create_task(work)
    await asyncio.wait((serving, working), return_when=asyncio.FIRST_COMPLETED)
    server.should_exit = True
    working.cancel()
    await serving
    with suppress(asyncio.CancelledError):
        await working
