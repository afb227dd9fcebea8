"""Which stops take effect: all but those of an operator whose grant is known to have ended."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots import bus
from workers.authority.memory import stops

GRANTS = st.integers(1, 12)


@pytest.mark.parametrize(
    ("grant", "newest", "ended", "heeded"),
    [
        (0, 9, {7, 8, 9}, True),  # staff, the row
        (9, 9, set(), True),  # who operates now
        (9, 9, {9}, False),  # whose turn has ended
        (7, 9, set(), False),  # somebody else's was opened since
        (10, 9, {9}, True),  # newer than anything we know
        (5, 0, set(), True),  # nothing is known yet
    ],
)
def test_the_table(grant, newest, ended, heeded):
    assert stops(grant, newest, ended) is heeded


@pytest.mark.asvs("8.3.1")
@given(st.lists(st.booleans(), max_size=12), GRANTS, st.data())
def test_no_stop_of_the_grant_that_is_open_is_ever_lost(story, grant, data):
    """Grants open one after another, the owner hears of some openings and some ends: it never knows too much."""
    opened, is_open, newest, ended = 0, False, 0, set()
    for hears in story:
        if is_open:
            is_open = False
            if hears:
                ended.add(opened)
        else:
            opened, is_open = opened + 1, True
            if hears:
                newest = opened
    assert stops(0, newest, ended)
    if is_open:
        assert stops(opened, newest, ended)
    assert stops(opened + grant, newest, ended), "what is not known stops"
    if newest and opened > 1:
        assert not stops(data.draw(st.integers(1, newest - 1)) if newest > 1 else -1, newest, ended) or newest == 1


@given(st.binary(max_size=60))
def test_a_word_that_cannot_be_read_stops(data):
    assert bus.grant_of_stop(data) >= 0
    assert bus.grant_of_stop(b"stop") == bus.grant_of_stop(b"stop -3") == bus.grant_of_stop(b"stop 3 4") == 0
    assert bus.grant_of_stop(b"stop 42") == 42
