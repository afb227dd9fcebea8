"""Makes the movies that are asked for or due, one at a time, each in a process of the lowest priority."""

import contextlib
import json
import logging
import os
import secrets
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import IO

from django.conf import settings

from robots.kit.clock import Clock
from robots.models import Movie
from robots.recordings import keeping, movies

log = logging.getLogger(__name__)
LONGEST_S = 600.0
DUE_S = 10.0  # between two looks for jobs of which a movie is due
SAID = 200_000  # bytes of what its process prints at most; its first line may be a path
LEAST = 19  # the niceness of what may wait for everything else
COMMAND = (sys.executable, "-m", "robots.kit.recording.movie")


class MovieMaker:
    """Looks for movies that wait; `look` returns at once. `nice`: the niceness of the process that makes one."""

    def __init__(self, clock: Clock, nice: int = LEAST) -> None:
        self._clock, self._nice = clock, nice
        self._movie: Movie | None = None
        self._process: subprocess.Popen[str] | None = None
        self._part, self._percent = Path(), 0  # of the movie that is made: its file, and how far it is
        self._said: IO[str] | None = None  # what its process has printed
        self._begun, self._looked = 0.0, -DUE_S
        self._track = False  # of the movie that is made: its path was noted
        movies.again()  # of who made movies here before

    def look(self) -> None:
        """Take what has been made, and begin the next."""
        if self._movie is not None and self._process is not None:
            if self._process.poll() is None:
                if self._clock.monotonic() - self._begun > LONGEST_S:
                    self._process.kill()
                self._tell(self._movie)
                return
            self._take(self._movie, self._process)  # again at the next look, if it could not be noted
            self._movie = self._process = None
            if self._said is not None:
                self._said.close()
                self._said = None
        if self._clock.monotonic() - self._looked >= DUE_S:
            self._looked = self._clock.monotonic()
            movies.ask_due(self._clock.now())
        movie = movies.claim(self._clock.now())
        if movie is not None:
            self._begin(movie)

    def _begin(self, movie: Movie) -> None:
        plan = movies.plan_of(movie)
        if not plan["files"] or not keeping.room():
            why = "Nothing of it is kept any more." if not plan["files"] else "The server's disk has no room for it."
            movies.finish(movie, None, why, self._clock.now())
            return
        path = keeping.movie_path(movie)
        self._part = path.with_name(f"{path.stem}-{secrets.token_hex(4)}.part")
        try:
            self._part.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile("w+") as plan_in:  # a pipe takes only 64 kB before somebody reads it
                json.dump(plan, plan_in)
                plan_in.seek(0)
                self._said, self._percent = tempfile.TemporaryFile("w+"), 0  # noqa: SIM115 - closed when it is made
                self._process = subprocess.Popen(  # noqa: S603 - our own module
                    [*COMMAND, movie.kind, str(self._part), str(self._nice)], stdin=plan_in, stdout=self._said,
                    stderr=subprocess.DEVNULL, text=True, cwd=settings.BASE_DIR,
                )  # fmt: skip
        except OSError as error:
            log.warning("%s cannot be made: %s", movie, error)
            movies.finish(movie, None, "It could not be made.", self._clock.now())
            return
        self._movie, self._begun, self._track = movie, self._clock.monotonic(), False

    def _take(self, movie: Movie, process: "subprocess.Popen[str]") -> None:
        self._note_track(movie)
        count = self._lines()[-1]
        good = process.returncode == 0 and count.isdigit() and int(count) > 0
        why = "It has no pictures." if process.returncode == 0 else "It could not be made."
        there = self._part.exists() or keeping.movie_path(movie).exists()
        movies.finish(movie, self._part if good and there else None, why, self._clock.now())
        self._part.unlink(missing_ok=True)

    def _lines(self) -> list[str]:
        """Return what its process has printed, at least one line."""
        if self._said is None:
            return [""]
        said = os.pread(self._said.fileno(), SAID, 0)  # it shares its place in the file with its process
        return said.decode(errors="replace").splitlines() or [""]

    def _tell(self, movie: Movie) -> None:
        """Note how far it is, and once its path."""
        self._note_track(movie)
        percent, _, unit = self._lines()[-1].partition(" ")
        if unit == "%" and percent.isdigit() and int(percent) != self._percent:
            movies.progress(movie, int(percent))
            self._percent = int(percent)

    def _note_track(self, movie: Movie) -> None:
        first = self._lines()[0]
        if self._track or not first.startswith("{"):
            return
        with contextlib.suppress(ValueError):  # it is not whole yet
            movies.note_track(movie, json.loads(first))
            self._track = True

    def close(self) -> None:
        """End what is being made; it is begun again later."""
        if self._process is None:
            return
        self._process.kill()
        self._process.wait(5)
        if self._said is not None:
            self._said.close()
        self._part.unlink(missing_ok=True)
