"""`manage.py edge`: hears the movie that is broadcast, and serves it to browsers, as a cache may keep it."""

import asyncio
import random
from typing import Any
from urllib.parse import urlsplit

from django.conf import settings
from django.core.management.base import BaseCommand, CommandError, CommandParser

from portal.broadcast import answers, multicast, running
from portal.broadcast.edge import Edge
from portal.broadcast.serving import Serving
from portal.run.beside import beside, listener
from portal.run.serve import config
from portal.web.recordings.broadcast_key import broadcast_key

MB = 1024 * 1024


class Command(BaseCommand):
    """Be an edge of the broadcast."""

    help = "Hear a broadcast (manage.py broadcast) and serve its movie by HTTP. FARHAND_BROADCAST_KEY is the key."

    requires_system_checks = ()  # it is started again within a second

    def add_arguments(self, parser: CommandParser) -> None:
        """Add the group, the interface, the origin, and where to serve."""
        parser.add_argument("--group", default=settings.BROADCAST_GROUP, help="address:port")
        parser.add_argument("--interface", default=settings.BROADCAST_INTERFACE, help="where it comes, as eth0")
        parser.add_argument("--origin", default="", help="address of the origin, for what was lost: http://host:8010")
        parser.add_argument("--memory", type=int, default=256, help="MB of movies in memory")
        parser.add_argument("--host", default="127.0.0.1")
        parser.add_argument("--port", type=int, default=8011)

    def handle(self, *args: Any, **options: Any) -> None:
        """Hear and serve until stopped."""
        if options["memory"] < 1:
            raise CommandError("An edge needs memory for a movie.")
        try:
            origin = urlsplit(options["origin"])
            known = origin.scheme in ("http", "https") and origin.hostname and origin.port != 0
            if options["origin"] and not known:
                raise ValueError("The origin is an address as http://host:8010.")
            key, group = broadcast_key(options["interface"]), multicast.group_of(options["group"])
            line = multicast.receiver(group, options["interface"])
        except (ValueError, OSError) as error:
            raise CommandError(str(error)) from error
        with line:
            asyncio.run(
                self._hear(Edge(key, random.random, options["memory"] * MB), running.Line(line, group), options)
            )

    async def _hear(self, edge: Edge, line: running.Line, options: dict[str, Any]) -> None:
        serving = Serving(edge, running.now_ns)
        host, port = options["host"], options["port"]
        listens = await listener(host, port, "FARHAND_BROADCAST_EDGES", self._tell)
        self._tell(f"the movie: http://{host}:{port}/")
        served = config(host, port, answers.application(serving.answer))
        await beside(served, listens, running.Receiving(edge, line, options["origin"]).run())

    def _tell(self, text: str) -> None:
        self.stdout.write(text)
        self.stdout.flush()
