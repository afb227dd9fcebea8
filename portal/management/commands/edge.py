"""`manage.py edge`: hears the movie that is broadcast, and serves it to browsers, as a cache may keep it."""

import asyncio
import random
from typing import Any
from urllib.parse import urlsplit

from django.core.management.base import CommandError, CommandParser

from portal.broadcast import multicast, running
from portal.broadcast.edge import Edge
from portal.broadcast.serving import Serving
from portal.management.broadcasting import BroadcastCommand, broadcast_key

MB = 1024 * 1024


class Command(BroadcastCommand):
    """Be an edge of the broadcast."""

    help = "Hear a broadcast (manage.py broadcast) and serve its movie by HTTP. FARHAND_BROADCAST_KEY is the key."
    port_setting = "FARHAND_BROADCAST_EDGES"

    def add_arguments(self, parser: CommandParser) -> None:
        """Add the group, the interface, the origin, and where to serve."""
        super().add_arguments(parser)
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
            edge = Edge(key, random.random, options["memory"] * MB)
            work = running.Receiving(edge, running.Line(line, group), options["origin"]).run
            text = f"the movie: http://{options['host']}:{options['port']}/"
            asyncio.run(self.serve(Serving(edge, running.now_ns).answer, work, options, text))
