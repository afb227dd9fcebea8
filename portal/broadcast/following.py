"""Changes the movie of an origin while it runs: to another one, or to silence after a movie that was withdrawn."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import NamedTuple

from portal.broadcast import media
from portal.broadcast.edge import GONE_NS
from portal.broadcast.media import NoMovie
from portal.broadcast.origin import Origin, words
from portal.broadcast.timetable import SECOND

log = logging.getLogger(__name__)
LOOK_S = 5.0  # between two looks whether another movie is to be shown
SILENT_S = GONE_NS / SECOND + 5  # after a movie that was withdrawn: until then every edge has forgotten it


class Choice(NamedTuple):
    """A movie's file, its key, and its title."""

    key: int
    path: Path
    title: str


Choosing = Callable[[int], Awaitable[tuple[Choice | None, bool]]]


class Following:
    """Has an origin show the chosen movie: `choose` returns it, and whether the movie shown may still be shown.

    A movie that was withdrawn is followed by silence, so that edges forget it before another one begins.
    """

    def __init__(self, origin: Origin, slot_ms: int, choose: Choosing, tell: Callable[[str], None]) -> None:
        self._origin, self._slot_ms, self._choose, self._tell = origin, slot_ms, choose, tell
        self._shown = self._refused = 0  # keys
        self._away = False

    async def run(self) -> None:
        """Look again and again."""
        while True:
            await asyncio.sleep(await self.look())

    async def look(self) -> float:
        """Look once. Return after how many seconds to look again."""
        try:
            choice, still = await self._choose(self._shown)
        except Exception as error:  # noqa: BLE001 - the database is away: the present movie goes on
            if not self._away:
                log.warning("it cannot be read now which movie is to be shown: %s", error)
            self._away = True
            return LOOK_S
        self._away = False
        if self._shown and (choice is None or not still):
            self._shown = 0
            self._origin.rest()
            self._tell("the movie was withdrawn: nothing is sent until every edge has forgotten it")
            return SILENT_S
        if choice is not None and choice.key not in (self._shown, self._refused):
            await self._begin(choice)
        return LOOK_S

    async def _begin(self, choice: Choice) -> None:
        try:
            movie = await asyncio.to_thread(media.cut, choice.path, self._slot_ms, choice.title)
        except OSError as error:  # it was removed just now
            log.warning("%s cannot be read: %s", choice.path, error)
            return
        except NoMovie as error:
            self._refused = choice.key
            self._tell(f"{choice.title} is not sent. {error}")
            return
        sent = self._origin.show(movie)
        self._shown = choice.key
        self._tell(f"{choice.title}: {words(movie, sent)}")
