"""Tapes, pictures and movies for tests of recordings."""

from contextlib import contextmanager

import cv2
import numpy as np

from robots.kit.clock import SYSTEM, ms_of
from robots.kit.recording.container import Tape
from robots.models import Movie
from robots.recordings import keeping
from tests.conftest import wait_for
from workers.recorder.movies import MovieMaker


def jpeg(grey):
    return cv2.imencode(".jpg", np.full((164, 193), grey, np.uint8))[1].tobytes()


@contextmanager
def tape_of(recording, about=None):
    """Yield a tape that becomes the recording's file, and when the recording began (ms since 1970)."""
    path = keeping.path_of(recording)
    path.parent.mkdir(parents=True, exist_ok=True)
    tape = Tape(path, about or {})
    yield tape, ms_of(recording.began_at)
    tape.close()


def let_make(movie, maker=None):
    """Have the program make it, until it is ready or could not be made; with our priority, for a busy machine."""
    maker = maker or MovieMaker(SYSTEM, nice=0)
    tries = Movie.objects.get(pk=movie.pk).tries
    maker.look()

    def done():
        maker.look()
        movie.refresh_from_db()
        return not movie.open or movie.tries > tries

    wait_for(done, 300, "the movie")
    return movie
