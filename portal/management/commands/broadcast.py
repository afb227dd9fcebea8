"""`manage.py broadcast`: sends the movie of the day to a multicast group, again and again, for any number of edges."""

import asyncio
from functools import partial
from pathlib import Path
from typing import Any

from asgiref.sync import sync_to_async
from django.conf import settings
from django.core.management.base import CommandError, CommandParser
from django.db import close_old_connections

from portal.broadcast import media, multicast, running
from portal.broadcast.following import Choice, Following
from portal.broadcast.origin import Origin, words
from portal.management.broadcasting import BroadcastCommand, broadcast_key
from portal.web.recordings import day
from robots.kit.clock import SYSTEM


class Command(BroadcastCommand):
    """Broadcast a movie."""

    help = (
        "Send the movie of the day, or a file (MP4, H.264), to a multicast group, for edges (manage.py edge). "
        "FARHAND_BROADCAST_KEY is the key."
    )
    port_setting = "FARHAND_BROADCAST_PORT"

    def add_arguments(self, parser: CommandParser) -> None:
        """Add the movie, the group, the interface, and how to send."""
        super().add_arguments(parser)
        parser.add_argument("file", type=Path, nargs="?", help="without one, the movie of the day as it is chosen")
        parser.add_argument("--title", default="", help="of the file, shown to viewers")
        parser.add_argument("--hops", type=int, default=1, help="routers that the packets may pass, and one")
        parser.add_argument("--wait", type=float, default=4.0, help="seconds that an edge waits at most (0.2 to 25)")
        parser.add_argument("--m", type=int, default=4, help="slots of that wait: more need less bandwidth (1 to 32)")
        parser.add_argument("--host", default=settings.BROADCAST_HOST, help="where edges ask for what was lost")
        parser.add_argument("--port", type=int, default=settings.BROADCAST_PORT)

    def handle(self, *args: Any, **options: Any) -> None:
        """Send until stopped; with a file, first write its length and rate."""
        wait_ds = round(options["wait"] * 10)
        if not 2 <= wait_ds <= 250 or not 1 <= options["m"] <= 32:
            raise CommandError("The wait is 0.2 to 25 seconds, m is 1 to 32.")
        if not 1 <= options["hops"] <= 255:
            raise CommandError("Packets pass 1 to 255 hops.")
        try:
            key, group = broadcast_key(options["interface"]), multicast.group_of(options["group"])
            slot_ms, file = max(1, wait_ds * 100 // options["m"]), options["file"]
            movie = media.cut(file, slot_ms, options["title"]) if file is not None else None
            line = multicast.sender(options["interface"], options["hops"])
        except (ValueError, OSError) as error:
            raise CommandError(str(error)) from error
        with line:
            origin = Origin(key, running.Line(line, group), wait_ds, _number)
            asyncio.run(self._send(origin, Following(origin, slot_ms, _choose, self.write), movie, options))

    async def _send(
        self, origin: Origin, following: Following, movie: media.Movie | None, options: dict[str, Any]
    ) -> None:
        if movie is not None:
            self.write(words(movie, origin.show(movie)))
        work = origin.run if movie is not None else partial(_both, origin, following)
        await self.serve(origin.answer, work, options)


def _number() -> int:
    return int(SYSTEM.now().timestamp() * 10**6)


async def _both(origin: Origin, following: Following) -> None:
    async with asyncio.TaskGroup() as group:
        group.create_task(origin.run())
        group.create_task(following.run())


@sync_to_async
def _choose(shown: int) -> tuple[Choice | None, bool]:
    """Return the movie of the day, and whether the one that is shown now may still be."""
    close_old_connections()
    found = day.movie_of_the_day(SYSTEM.now())
    choice = None if found is None else Choice(found.movie.pk, found.path, found.title)
    return choice, (choice is not None and choice.key == shown) or day.may_be_shown(shown)
