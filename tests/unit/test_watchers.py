"""The number of viewers: people are counted, not pages, and an operator is not counted."""

import asyncio

from hypothesis import given
from hypothesis import strategies as st

from portal.live.loop import LoopState
from portal.live.rooms import Room
from portal.live.viewer import STRANGER, Viewer
from portal.live.watchers import Watchers, read_watchers, together

SOME = st.builds(Watchers, st.integers(0, 5000), st.frozensets(st.integers(1, 30)), st.integers(0, 2**40))
PAGES = st.lists(st.tuples(st.integers(0, 6), st.booleans(), st.booleans()), max_size=20)  # person, drives, still here


@given(SOME)
def test_what_a_process_tells_others_understand(one):
    assert read_watchers(one.text().encode()) == one


@given(st.binary(max_size=40))
def test_what_is_not_understood_is_nobody(told):
    assert together([read_watchers(told)]) >= 0


def test_what_a_process_of_the_version_before_tells_is_understood():
    assert together([read_watchers(b"3 1700000000")]) == 3


@given(st.lists(SOME, max_size=5))
def test_a_person_with_pages_in_several_processes_is_one(several):
    people = {person for one in several for person in one.people}
    assert together(several) == sum(one.strangers for one in several) + len(people)


@given(PAGES)
def test_a_robots_room_counts_strangers_pages_and_people_who_do_not_drive(pages):
    async def count():
        room = Room("mercury")
        for person, drives, stays in pages:
            viewer = Viewer("mercury")
            viewer.visitor = STRANGER if not person else 0 if drives else person
            room.add(viewer)
            if not stays:
                room.remove(viewer)
        return room.watching()

    here = [(person, drives) for person, drives, stays in pages if stays]
    people = {person for person, drives in here if person and not drives}
    assert asyncio.run(count()) == sum(not person for person, _ in here) + len(people)


def test_whose_turn_begins_watches_no_more_and_does_again_when_it_is_over():
    async def counts():
        hub, seen = LoopState().hub, []
        room = hub._rooms.setdefault("mercury", Room("mercury"))
        pages = [Viewer("mercury"), Viewer("mercury")]  # of one person
        for viewer in pages:
            room.add(viewer)
        for drives in (False, True, False):
            for viewer in pages:
                hub.count_as(viewer, 0 if drives else 7)
            seen.append(hub.watchers("mercury"))
        return seen

    assert asyncio.run(counts()) == [1, 0, 1]
