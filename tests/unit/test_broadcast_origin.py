"""An origin that follows what is chosen: another movie without a restart, silence after one that was withdrawn."""

import asyncio
import socket

import pytest

from portal.broadcast import running
from portal.broadcast.edge import GONE_NS
from portal.broadcast.following import LOOK_S, SILENT_S, Choice, Following
from portal.broadcast.origin import Origin
from portal.broadcast.timetable import SECOND
from tests.broadcasting import KEY
from tests.unit.test_broadcast_served import film


class Station:
    """An origin on the loopback and what it is told to show; `look` looks once and returns when to look again."""

    def __init__(self, line):
        self.origin = Origin(KEY, running.Line(line, ("239.8.1.77", 5004)), 10, iter(range(1, 10**6)).__next__)
        self.choice, self.still, self.said, self.asked = None, True, [], []
        self._following = Following(self.origin, 250, self._choose, self.said.append)

    async def _choose(self, shown):
        self.asked.append(shown)
        if isinstance(self.choice, Exception):
            raise self.choice
        return self.choice, self.still

    def look(self, choice, still=True):
        self.choice, self.still = choice, still
        return asyncio.run(self._following.look())

    @property
    def shown(self):
        status = self.origin.answer("/status.json", {}).body
        return None if b"null" in status else status[11:19].decode()


@pytest.fixture
def station():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        yield Station(line)


@pytest.fixture
def two(tmp_path):
    return [Choice(n, film(tmp_path / f"{n}.mp4", n + 2), f"Rover, {n} June 2026") for n in (1, 2)]


def test_without_a_movie_it_rests(station):
    assert station.look(None) == LOOK_S
    assert station.shown is None and station.origin.answer("/00000001/1", {}).status == 404
    assert station.said == []


def test_another_movie_is_taken_without_a_restart(station, two):
    station.look(two[0])
    first = station.shown
    assert first and "Rover, 1 June 2026: 3 s in" in station.said[0]
    assert station.look(two[0]) == LOOK_S and station.shown == first and len(station.said) == 1
    assert station.look(two[1]) == LOOK_S
    assert station.shown not in (None, first) and station.asked == [0, 1, 1]


@pytest.mark.parametrize("next_one", [None, 1])
def test_after_a_movie_that_was_withdrawn_it_is_silent_until_every_edge_has_forgotten_it(station, two, next_one):
    station.look(two[0])
    following = two[next_one] if next_one else None
    assert station.look(following, still=False) == SILENT_S > GONE_NS / SECOND
    assert station.shown is None
    station.look(two[1])
    assert station.shown is not None and station.asked[-1] == 0


def test_a_movie_that_nobody_chooses_any_more_is_not_sent(station, two):
    station.look(two[0])
    assert station.look(None) == SILENT_S and station.shown is None


def test_while_the_database_is_away_what_is_sent_goes_on(station, two, caplog):
    station.look(two[0])
    first = station.shown
    for _ in range(3):
        assert station.look(OSError("no database")) == LOOK_S
    assert station.shown == first and caplog.text.count("cannot be read now") == 1
    station.look(two[1])
    assert station.shown not in (None, first)


def test_what_cannot_be_sent_is_told_once_and_the_one_before_goes_on(station, two, tmp_path):
    station.look(two[0])
    first = station.shown
    (tmp_path / "bad.mp4").write_bytes(b"no movie at all")
    bad = Choice(3, tmp_path / "bad.mp4", "Arm, 3 June 2026")
    for _ in range(2):
        station.look(bad)
    assert station.shown == first
    assert [text for text in station.said if text.startswith("Arm")] == [
        text for text in station.said[1:] if "Arm, 3 June 2026 is not sent. It is no movie that can be broadcast" in text
    ] != []  # fmt: skip
    assert len(station.said) == 2


def test_a_file_that_was_removed_at_that_moment_is_looked_for_again(station, two):
    gone = Choice(7, two[0].path.with_name("gone.mp4"), "Gone")
    assert station.look(gone) == LOOK_S and station.shown is None
    film(gone.path, 2)
    station.look(gone)
    assert station.shown is not None
