"""`python -m portal.run.serve`: the web process, uvicorn with the portal's limits."""

import argparse
import asyncio
import os
import resource
import signal
import socket
import sys

os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")

import uvicorn
from django.conf import settings

from portal.broadcast.answers import Application
from portal.edge.protocols import Http
from portal.edge.sockets import Ws

MESSAGE = 16_384  # bytes of a socket's message; the application accepts half of that


def config(host: str, port: int, app: str | Application = "portal.asgi:application") -> uvicorn.Config:
    """Return the settings of the web server.

    Without trusted proxies no headers of proxies are read; uvicorn's default would trust 127.0.0.1.
    """
    proxies = settings.TRUSTED_PROXIES
    return uvicorn.Config(
        app, host=host, port=port, http=Http, ws=Ws, ws_max_size=MESSAGE, ws_ping_interval=15, ws_ping_timeout=20,
        timeout_keep_alive=5, timeout_graceful_shutdown=3, lifespan="off", access_log=False, log_level="warning",
        log_config=None,  # uvicorn's own handlers would neither bound nor escape a line
        proxy_headers=bool(proxies), forwarded_allow_ips=proxies, server_header=False,
    )  # fmt: skip


class Server(uvicorn.Server):
    """uvicorn's server, which tells the queues that people can reach it."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin to serve."""
        await super().startup(sockets)
        if self.started and self.config.port != settings.OPERATORS_PORT:  # that one serves no pages
            from portal.run.uptime import tell_on  # noqa: PLC0415 - after Django's setup, which came with the application

            self._telling = asyncio.create_task(tell_on())


def main() -> None:
    """Serve until stopped."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=8000)
    parser.add_argument("--app", default="portal.asgi:application")
    asked = parser.parse_args()
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))  # each socket needs a file descriptor
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())  # uvicorn raises it again at its end: the log is written first
    Server(config(asked.host, asked.port, asked.app)).run()


if __name__ == "__main__":
    main()
