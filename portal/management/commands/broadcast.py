"""`manage.py broadcast FILE.mp4`: sends a movie to a multicast group, again and again, for any number of edges."""

import asyncio
from pathlib import Path
from typing import Any

from django.conf import settings
from django.core.management.base import BaseCommand, CommandError, CommandParser

from portal.broadcast import answers, media, multicast, packets, running
from portal.broadcast.carousel import Carousel
from portal.broadcast.repairs import Repairs
from portal.broadcast.timetable import bytes_a_second
from portal.serve import beside, config
from robots.clock import SYSTEM

REPAIRS = 10  # times the movie's rate
HEADERS = packets.DATAGRAM - packets.PAYLOAD + packets.UDP_IP


class Command(BaseCommand):
    """Broadcast a movie."""

    help = (
        "Send a movie (MP4, H.264) to a multicast group, for edges (manage.py edge). FARHAND_BROADCAST_KEY is the key."
    )

    def add_arguments(self, parser: CommandParser) -> None:
        """Add the movie, the group and the interface."""
        parser.add_argument("file", type=Path)
        parser.add_argument("--group", default="239.8.1.30:5004", help="address:port")
        parser.add_argument("--interface", default="lo", help="of the network of the edges, as eth0")
        parser.add_argument("--hops", type=int, default=1, help="routers that the packets may pass, and one")
        parser.add_argument("--wait", type=float, default=4.0, help="seconds that an edge waits at most (0.2 to 25)")
        parser.add_argument("--m", type=int, default=4, help="slots of that wait: more need less bandwidth (1 to 32)")
        parser.add_argument("--host", default="127.0.0.1", help="address at which edges ask for what was lost")
        parser.add_argument("--port", type=int, default=8010)

    def handle(self, *args: Any, **options: Any) -> None:
        """Cut the movie, say what it takes, and send until stopped."""
        wait_ds = round(options["wait"] * 10)
        if not 2 <= wait_ds <= 250 or not 1 <= options["m"] <= 32:
            raise CommandError("The wait is 0.2 to 25 seconds, m is 1 to 32.")
        if not 1 <= options["hops"] <= 255:
            raise CommandError("Packets pass 1 to 255 hops.")
        try:
            key, group = packets.key_of(settings.BROADCAST_KEY), multicast.group_of(options["group"])
            movie = media.cut(options["file"], max(1, wait_ds * 100 // options["m"]))
            line = multicast.sender(options["interface"], options["hops"])
        except (ValueError, OSError) as error:
            raise CommandError(str(error)) from error
        with line:
            asyncio.run(self._send(movie, key, wait_ds, running.Line(line, group), options))

    async def _send(
        self, movie: media.Movie, key: bytes, wait_ds: int, line: running.Line, options: dict[str, Any]
    ) -> None:
        now = running.now_ns()
        number = int(SYSTEM.now().timestamp() * 10**6)
        carousel = Carousel(key, movie.contents, movie.starts_ns, wait_ds, now, number)
        rate = float(bytes_a_second(carousel.channels, HEADERS))
        self.stdout.write(
            f"{movie.seconds:.0f} s in {len(movie.contents) - 1} segments, {movie.rate / 1000:.0f} kB/s; "
            f"broadcast {rate / 1000:.0f} kB/s with headers, {rate / movie.rate:.2f} times, for any number of edges"
        )
        self.stdout.flush()
        repairs = Repairs(carousel, key, REPAIRS * movie.rate, running.now_ns)
        served = config(options["host"], options["port"], answers.application(repairs.answer))
        await beside(served, running.Sending(carousel, line).run())
