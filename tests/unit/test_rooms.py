"""For the viewers of a robot a web process hears and computes what they want, and nothing else."""

import asyncio

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from portal.live import rooms
from portal.live.messages import Watch
from portal.live.rooms import Room
from portal.live.viewer import Cameras, Viewer, Wish
from robots.kit.contract.video import VideoPacket, pack
from robots.kit.packets import TAKEN_DOWN, Changed

KEY, NEXT, AFTER = (pack(VideoPacket(0, n, 2000 + 40 * n, 0, b"vp8", n - 1 or None)) for n in (1, 2, 3))
ALWAYS = {"farhand:arm:events", "farhand:arm:state", "farhand:arm:stream", "farhand:arm:path"}


@pytest.fixture
def computed(monkeypatch):
    """The frames that are computed."""
    made = []
    monkeypatch.setattr(rooms, "binary_frame", lambda data: made.append(data) or data)
    return made


def viewer(room, *cameras, **wish):
    one = Viewer("arm")
    one.choose(Wish.of(Watch(list(cameras), **wish)).within(room.cameras))
    room.add(one)
    return one


class Line:
    """A connection that takes `room` frames, until it is emptied."""

    deflates = False
    window = 0

    def __init__(self, room=99):
        self.room, self.written, self._kept, self.ready, self._call = room, [], False, True, None

    def write(self, frame):
        self.written.append(frame)
        self.room -= 1
        self._judge()

    def emptied(self, room):
        self.room = room
        self._judge()

    def bound(self, on):
        pass

    remember = bound

    def keep(self, waits):
        self._kept = waits
        self._judge()

    def when_ready(self, call):
        self._call = call

    def _judge(self):
        self.ready = self.room > 0 and not self._kept
        if self._call:
            self._call()


def placed(room, line, **wish):
    one = Viewer("arm", line)
    one.choose(Wish.of(Watch([0], **wish)))
    room.add(one)
    one.set_empty()
    return one


def test_a_picture_goes_at_once_to_whoever_is_ready_and_waits_for_the_others(computed):
    async def give():
        room = Room("arm")
        lines = [Line(), Line(1), Line(0), Line()]
        one, two, three, gone = (placed(room, line) for line in lines)
        room.remove(gone)
        for n in range(3):
            room.give_picture(0, b"%d" % n)
        assert [line.written for line in lines] == [[b"0", b"1", b"2"], [b"0"], [], []]
        assert [v._pictures for v in (one, two, three, gone)] == [{}, {0: b"2"}, {0: b"2"}, {}]
        lines[1].emptied(9)
        room.give_picture(0, b"3")
        assert lines[1].written == [b"0"], "what waits in the mailbox comes first"
        assert two.take_picture() == b"3"
        two.set_empty()
        room.give_picture(0, b"4")
        assert (lines[0].written[-1], lines[1].written) == (b"4", [b"0", b"4"])
        assert gone._groups == ()

    asyncio.run(give())


@settings(max_examples=50)
@given(st.lists(st.tuples(st.integers(0, 3), st.sampled_from(["add", "remove", "keep", "free", "fill", "give"]))))
def test_every_group_knows_who_is_ready(steps):
    async def walk():
        room, lines = Room("arm"), [Line(2) for _ in range(4)]
        viewers = [placed(Room("other"), line) for line in lines]
        for which, step in steps:
            one, line = viewers[which], lines[which]
            match step:
                case "add":
                    room.add(one)
                case "remove":
                    room.remove(one)
                case "keep":
                    line.keep(True)
                case "free":
                    line.keep(False)
                    line.emptied(2)
                case "fill":
                    line.emptied(0)
                case "give":
                    room.give_picture(0, b"picture")
                    room.give_state(b"state", False)
            for group in (room.each[0, False], room.states[False]):
                assert set(group) == set(room.viewers)
                assert all((write is not None) is v.ready() for v, write in group.items())

    asyncio.run(walk())


def test_a_picture_that_was_taken_down_is_given_to_no_newcomer():
    room = Room("arm")
    viewer(room, 0)
    room.give_picture(0, b"\x02 picture")
    room.give_event(Changed("frame"), False)
    assert room.newest == {0: b"\x02 picture"}, "a picture that was stored changes nothing"
    room.give_event(TAKEN_DOWN, False)
    assert room.newest == {}


def test_nothing_is_computed_or_kept_for_nobody(computed):
    room = Room("arm")
    one = viewer(room, 1)
    for coarse in (False, True):
        room.give_picture(0, b"\x02 picture", coarse)
        assert room.give_video(0, KEY, coarse)
        assert room.give_video(0, NEXT, coarse), "no key picture is asked for"
        room.give_state(b"\x80 compact", True)
    assert not computed
    assert not any(videos._chains for videos in room.videos.values())
    room.give_picture(1, b"\x02 picture")
    assert computed == [b"\x02 picture"]
    assert one._pictures == {1: b"\x02 picture"}


def test_whoever_films_later_gets_no_part_of_a_group_that_has_gaps():
    async def film():
        room = Room("arm")
        first = viewer(room, 0, video="vp8")
        assert room.give_video(0, KEY, False)
        room.remove(first)
        assert room.give_video(0, NEXT, False)
        second = viewer(room, 0, video="vp8")
        assert room.take_missing(second) == []
        assert room.keys() == {"video.key"}
        assert not room.give_video(0, AFTER, False), "a key picture is needed"
        assert room.give_video(0, KEY, False)
        assert room.take_missing(second) == [KEY]

    asyncio.run(film())


def test_empty_groups_are_dropped():
    room = Room("arm")
    wishes = [{}, {"coarse": True}, {"every_s": 5.0}, {"video": "vp8"}, {"video": "vp8", "coarse": True}]
    here = [viewer(room, *range(8), **wish) for wish in wishes]
    assert len(room.each) == len(room.film) == 16
    for one in here:
        room.remove(one)
    assert not (room.each or room.film or room.some)


def test_channels_are_those_of_what_somebody_wants():
    room = Room("arm")
    assert room.channels() == ALWAYS
    plain, small = viewer(room, 0), viewer(room, 2, compact=True, video="vp8", coarse=True)
    assert room.channels() == ALWAYS | {"farhand:arm:frames", "farhand:arm:compact", "farhand:arm:coarsevideo2"}
    room.remove(plain)
    viewer(room, 1, every_s=5.0).trace = True
    room.remove(small)
    assert room.channels() == ALWAYS | {"farhand:arm:frames1"}


def test_cameras_that_the_robot_does_not_have_are_left_out_of_a_wish():
    room = Room("arm")
    room.cameras = Cameras(2)
    assert viewer(room, 0, 1, 2, 7).wish.cameras == {0, 1}
    assert room.watched() == {"frames", "frames1"}
    room.cameras = Cameras(0)
    assert viewer(room, 0, 5).wish.cameras == set()


def test_who_decodes_another_coding_than_the_robots_gets_jpeg():
    room = Room("arm")
    assert (viewer(room, 0, video="vp8").films(0), viewer(room, 0, video="vp9").films(0)) == (True, False)
    room.cameras = Cameras(2, "vp9")
    assert (viewer(room, 0, video="vp8").films(0), viewer(room, 0, video="vp9").films(0)) == (False, True)
    one = viewer(room, 0, video="vp8")
    assert one in room.each[0, False]
