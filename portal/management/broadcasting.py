"""The common part of the commands `broadcast` and `edge`: the group, its key, and an HTTP server beside the work."""

import asyncio
import errno
import socket
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any

import uvicorn
from django.conf import settings
from django.core.management.base import BaseCommand, CommandParser
from django.utils.crypto import salted_hmac

from portal.broadcast import answers, packets

AGAIN_S, BACKLOG = 5.0, 512  # between two tries to have a port; connections that may wait to be taken
LOOPBACK = "lo"
Work = Callable[[], Coroutine[Any, Any, None]]


class BroadcastCommand(BaseCommand):
    """The base class of both commands; `port_setting` is the setting that chooses another port."""

    requires_system_checks = ()  # it is started again within a second
    port_setting = ""

    def add_arguments(self, parser: CommandParser) -> None:
        """Add the group and the interface."""
        parser.add_argument("--group", default=settings.BROADCAST_GROUP, help="address:port")
        parser.add_argument(
            "--interface", default=settings.BROADCAST_INTERFACE, help="of the network of origin and edges, as eth0"
        )

    async def serve(self, answering: answers.Answering, work: Work, options: dict[str, Any], text: str = "") -> None:
        """Serve at the host and port of the options while the work goes on; write `text` when the port is open."""
        from portal.run.serve import config  # noqa: PLC0415 - a module that `python -m` runs is not preloaded

        host, port = options["host"], options["port"]
        line = await listener(host, port, self.port_setting, self.write)
        if text:
            self.write(text)
        await beside(config(host, port, answers.application(answering)), line, work())

    def write(self, text: str) -> None:
        """Write a line at once."""
        self.stdout.write(text)
        self.stdout.flush()


def broadcast_key(interface: str) -> bytes:
    """Return the key: that of the settings, or, on the machine itself, one of this installation.

    Raises ValueError where a key has to be given.
    """
    told = settings.BROADCAST_KEY
    if not told and interface == LOOPBACK:
        told = salted_hmac("portal.broadcast", "key", algorithm="sha256").hexdigest()
    if not told:
        raise ValueError(f"On {interface}, origin and edges need the same FARHAND_BROADCAST_KEY.")
    return packets.key_of(told)


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
