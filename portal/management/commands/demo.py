"""`manage.py demo`: migrates, seeds, and runs every process under one supervisor."""

import asyncio
import contextlib
import http.client
import os
import socket
import sys
from collections.abc import Callable
from typing import Any

from asgiref.sync import sync_to_async
from django.conf import settings
from django.core.management import CommandError, call_command
from django.core.management.base import BaseCommand, CommandParser
from django.db import close_old_connections

from portal.folders import tighten
from portal.keep.seeding import seed
from portal.run.processes import (
    broadcast_processes,
    enabled_processes,
    housekeeping_process,
    recorder_process,
    redis_process,
    web_process,
)
from portal.run.supervisor import Supervisor, flush, tidy_line
from robots.kit.clock import SYSTEM


class Command(BaseCommand):
    """Run the whole portal on this machine."""

    help = "Serve the portal with its robots, everything under one supervisor."
    requires_system_checks = ()  # made in `_prepare`

    def add_arguments(self, parser: CommandParser) -> None:
        """Add host and port."""
        parser.add_argument("--host", default="127.0.0.1")
        parser.add_argument("--port", type=int, default=settings.PORT)

    def handle(self, *args: Any, **options: Any) -> None:
        """Prepare, then supervise until Ctrl-C."""
        host, port = options["host"], options["port"]
        _need_port(host, port, "make run PORT=8001")
        if settings.OPERATORS_PORT:
            if port == settings.OPERATORS_PORT:
                raise CommandError(f"FARHAND_OPERATORS_PORT must be another port than the portal's {port}.")
            _need_port(host, settings.OPERATORS_PORT, "FARHAND_OPERATORS_PORT=8002 make run")
        begun = SYSTEM.awake()
        tighten(settings.VAR)
        password = _apart(self._prepare)
        fixed = [web_process(host, port), housekeeping_process(), recorder_process(), *broadcast_processes(host)]
        if settings.OPERATORS_PORT:
            fixed.append(web_process(host, settings.OPERATORS_PORT, "operators' web"))
        if "REDIS_URL" not in os.environ:
            fixed.insert(0, redis_process())

        @sync_to_async
        def read_enabled() -> Any:
            close_old_connections()
            return enabled_processes()

        first = _FirstPassword(password)

        async def main() -> None:
            async def ready() -> None:
                await _until_served(host, port)
                shown = "localhost" if host == "127.0.0.1" else host
                tidy_line("farhand", f"open http://{shown}:{port}  (ready in {SYSTEM.awake() - begun:.1f} s)")
                first.tell()

            await Supervisor(fixed, read_enabled).run(ready)

        try:
            with contextlib.suppress(KeyboardInterrupt):
                asyncio.run(main())
        finally:
            first.tell()  # also if it ended before it was served: the account has been made
            flush()

    def _prepare(self) -> str:
        """Check and update. Return the administrator's one-time password; empty if there is an administrator.

        Raises SystemCheckError.
        """
        self.check()
        call_command("migrate", verbosity=0, interactive=False)
        return seed() or ""


class _FirstPassword:
    """The password of an administrator who was made now; empty if there was one."""

    def __init__(self, password: str) -> None:
        self._password = password

    def tell(self) -> None:
        """Print it, once."""
        if self._password:
            tidy_line("farhand", f"admin account: admin   one-time password: {self._password}")
            tidy_line("farhand", "it is shown only once; change it at /admin/password_change/")
        self._password = ""


def _apart(work: Callable[[], str]) -> str:
    """Return the result of `work`, which runs in a child process, so that its imports use no memory afterwards."""
    ours, theirs = os.pipe()
    child = os.fork()
    if not child:
        status = 1
        try:
            os.write(theirs, work().encode())
            status = 0
        except Exception as error:  # noqa: BLE001 - it is written, and ends the command
            sys.stderr.write(f"{type(error).__name__}: {error}\n")
        finally:
            sys.stdout.flush()
            os._exit(status)
    os.close(theirs)
    with os.fdopen(ours, "rb") as pipe:
        answer = pipe.read().decode()
    if os.waitpid(child, 0)[1]:
        raise CommandError("The portal could not be prepared; see the messages above.")
    return answer


def _need_port(host: str, port: int, other: str) -> None:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise CommandError(
                f"Port {port} on {host} is taken ({error.strerror}). Stop the other process, or choose "
                f"another port: {other}"
            ) from error


def _named(host: str) -> str:
    """Return a host by which the portal answers; others are refused."""
    return next(iter(settings.ALLOWED_HOSTS), host).removeprefix(".")


async def _until_served(host: str, port: int) -> None:
    named = _named(host)

    def answered() -> bool:
        line = http.client.HTTPConnection(host, port, timeout=1)
        try:
            line.request("GET", "/livez", headers={"Host": named})
            line.getresponse()  # any answer: behind a proxy it may be a redirect
        except (OSError, http.client.HTTPException):
            return False
        finally:
            line.close()
        return True

    while not await asyncio.to_thread(answered):
        await asyncio.sleep(0.2)
