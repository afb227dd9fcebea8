"""The iRat's brain without its process: what it answers, what it streams, what it keeps."""

import struct

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.drivers.irat.brain import messages
from robots.kit.drivers.irat.brain.messages import Aim, Care, Clear, Feed, Key, frame, from_brain, read, to_brain
from robots.kit.drivers.irat.brain.mind import Mind
from robots.kit.drivers.irat.brain.streams import HEAD, CellStream, MapStream
from robots.kit.drivers.irat.messages import Odometry
from robots.kit.drivers.irat.protocol import Velocity
from robots.kit.drivers.irat.senses import between
from robots.kit.slam import storage
from tests.conftest import wait_for

HALL = np.random.default_rng(5).integers(0, 255, (24, 900), np.uint8)


def view(at):
    """Return a JPEG of a hall, as seen after so many metres."""
    part = HALL[:, int(at * 120) : int(at * 120) + 42]
    return cv2.imencode(".jpg", cv2.resize(part, (416, 240), interpolation=cv2.INTER_CUBIC))[1].tobytes()


def walk(mind, steps, at=0.0, speed=0.15):
    """Drive on from `at` m; return the answers."""
    found = []
    for n in range(steps):
        at += speed * 0.1
        found += mind.take(Feed(float(n), speed, 0.0, 0.1, view(at)))
    return found


def seen(answers):
    return [a for a in answers if isinstance(a, messages.Seen)]


def packets(answers, name="map"):
    return [a for a in answers if isinstance(a, messages.Packet) and a.stream == name]


def decoded(data, known=None):
    """Return what a console has after a packet of the map: number, places, links, route, docks, dock."""
    number, places, links, route, docks, dock = known or (0, {}, set(), (), (), (0, 0, 0))
    version, flags, number, nodes, pairs = HEAD.unpack_from(data)
    assert version == 1
    at = HEAD.size
    ids = np.frombuffer(data, "<u4", nodes, at)
    x, y = np.frombuffer(data, "<i2", 2 * nodes, at + 4 * nodes).reshape(2, -1)
    at += 8 * nodes
    ends = np.frombuffer(data, "<u4", 2 * pairs, at).reshape(-1, 2)
    at += 8 * pairs
    places = places | {int(i): (int(a), int(b)) for i, a, b in zip(ids, x, y, strict=True)}
    links = links | {tuple(map(int, pair)) for pair in ends}
    lists = []
    for flag, old in ((1, route), (2, docks)):
        if flags & flag:
            (count,) = struct.unpack_from("<H", data, at)
            lists.append(tuple(np.frombuffer(data, "<u4", count, at + 2).tolist()))
            at += 2 + 4 * count
        else:
            lists.append(old)
    if flags & 4:
        dock = struct.unpack_from("<hhH", data, at)
        at += 6
    assert at == len(data)
    return number, places, links, *lists, dock


@pytest.fixture
def mind(tmp_path):
    return Mind(tmp_path / "brain")


def test_a_walk_makes_experiences_and_the_stream_tells_each(mind):
    answers = walk(mind, 40)
    newest = seen(answers)[-1]
    assert newest.experiences > 10
    assert newest.pose[1] == pytest.approx(0.6, abs=0.05)
    told = packets(answers)
    assert [p.key for p in told][:2] == [True, False]
    known = None
    for packet in told:
        known = decoded(packet.data, known)
    held = mind.slam.map
    assert known[0] == newest.map_number
    assert set(known[1]) == set(held.ids[: held.count].tolist())
    for i, (x, y) in known[1].items():
        assert (x * 0.005, y * 0.005) == pytest.approx(tuple(held.poses[i, :2]), abs=0.006)
    assert len(known[2]) == held.linked


def test_a_key_packet_holds_everything(mind):
    walk(mind, 30)
    list(mind.take(Key("map")))
    told = packets(mind.take(Feed(9.0, 0.0, 0.0, 0.1)))
    assert [p.key for p in told] == [True]
    assert len(decoded(told[0].data)[1]) == mind.slam.map.count


def test_nothing_is_told_twice(mind):
    walk(mind, 10)
    assert packets(mind.take(Feed(9.0, 0.0, 0.0, 0.1))) == []


def test_a_goal_is_aimed_at_by_its_number_or_by_the_place_and_the_route_is_told(mind):
    answers = walk(mind, 40)
    number, middle = seen(answers)[-1].map_number, int(mind.slam.map.ids[5])
    x, y = mind.slam.map.poses[5, :2]
    for wanted in (Aim(1, number, 90.0, 90.0, middle), Aim(2, number, x + 0.01, y - 0.01)):
        (answer,) = mind.take(wanted)
        assert (answer.refusal, answer.number) == ("", wanted.number)
        assert answer.limit_s >= 30.0
    answers = list(mind.take(Feed(9.0, 0.0, 0.0, 0.1)))
    guided = seen(answers)[0].guided
    assert not guided.reached
    assert abs(guided.bearing) == pytest.approx(np.pi, abs=0.2), "behind it"
    assert decoded(packets(answers)[0].data)[3][-1] == guided.goal
    list(mind.take(messages.Forget()))
    assert seen(mind.take(Feed(10.0, 0.0, 0.0, 0.1)))[0].guided is None


@pytest.mark.parametrize(
    ("more", "words"),
    [({"map_number": 7}, "cleared"), ({"x": 50.0}, "No place")],
    ids=["another map", "nowhere"],
)
def test_a_goal_that_is_not_there_is_refused_with_a_sentence(mind, more, words):
    walk(mind, 10)
    (answer,) = mind.take(Aim(3, **{"map_number": mind.slam.map_number, "x": 0.0, "y": 0.0} | more))
    assert words in answer.refusal
    assert answer.cleared == ("map_number" in more)


def test_a_place_at_the_dock_is_refused_as_a_goal(mind):
    """There the low guides of the dock are: only docking leads to it."""
    walk(mind, 40)
    held, number = mind.slam.map, mind.slam.map_number
    (before,) = mind.take(Aim(1, number, 0.0, 0.0, int(held.ids[held.count - 1])))
    assert not before.refusal, "the dock was not seen yet"
    for index in range(held.count - 3, held.count):  # it is 1 m up the page
        mind.slam.docks.saw(int(held.ids[index]), 1.0 - 0.07 - float(held.poses[index, 1]), 0.0)
    (near,) = mind.take(Aim(2, number, 0.0, 0.0, int(held.ids[held.count - 1])))
    (far_away,) = mind.take(Aim(3, number, 0.0, 0.0, int(held.ids[0])))
    assert "only to charge" in near.refusal and not near.cleared
    assert not far_away.refusal
    list(mind.take(messages.Key("map")))
    told = packets(walk(mind, 15))
    known = None
    for one in told:
        known = decoded(one.data, None if one.key else known)
    x, y, within = (v * 0.005 for v in known[-1])
    assert (x, y, within) == (pytest.approx(0.0, abs=0.1), pytest.approx(1.0, abs=0.1), 0.42), (
        "so pages do not offer it"
    )
    mind.slam.docks.places.clear()
    for one in packets(walk(mind, 15)):
        known = decoded(one.data, None if one.key else known)
    assert known[-1] == (0, 0, 0)


def test_an_empty_map_has_no_goals(mind):
    (answer,) = mind.take(Aim(3, mind.slam.map_number, 0.0, 0.0))
    assert answer.refusal


def test_a_saved_map_goes_on_and_a_cleared_one_has_another_number(tmp_path):
    first = Mind(tmp_path)
    walk(first, 20)
    first.save()
    again = Mind(tmp_path)
    assert (again.slam.map.count, again.slam.map_number) == (first.slam.map.count, first.slam.map_number)
    list(again.take(Clear(1)))
    number = again.slam.map_number
    third = Mind(tmp_path)  # it died before the new map was saved
    assert third.slam.map_number > first.slam.map_number
    assert third.slam.map.count == 0
    assert third.slam.map_number >= number


def test_a_save_beside_writes_only_what_is_new_and_one_that_is_cut_off_loses_nothing(mind, tmp_path, monkeypatch):
    walk(mind, 20)
    for _ in range(2):
        mind._save_beside()
        wait_for(
            lambda: not mind._saving.locked() and (tmp_path / "brain" / "map.npz").exists(), 10, "the map is saved"
        )
        assert mind.slam.views.stored_count == mind.slam.views.count > 0
    known = mind.slam.map.count

    def killed(_):
        raise OSError("the disk is gone")

    mind.slam.views.stored_count = 0  # as after a copy that nobody told of the save before
    monkeypatch.setattr(storage.os, "fsync", killed)
    mind.save()
    monkeypatch.undo()
    assert Mind(tmp_path / "brain").slam.map.count == known


@pytest.mark.parametrize("damage", [b"", b"not a map", b"PK\x03\x04" + bytes(100)])
def test_a_damaged_map_is_a_new_one_under_a_new_number(tmp_path, damage):
    first = Mind(tmp_path)
    walk(first, 10)
    first.save()
    (tmp_path / "map.npz").write_bytes(damage)
    assert Mind(tmp_path).slam.map_number == first.slam.map_number + 1
    (tmp_path / "kept").write_bytes(b"\xff\xfe")
    assert Mind(tmp_path).slam.map_number >= 1


def test_pruning_is_kept(tmp_path):
    first = Mind(tmp_path)
    assert seen(walk(first, 5))[-1].pruning is False
    list(first.take(Care(1, True)))
    first.save()
    again = Mind(tmp_path)
    assert again.slam.settings.pruning is True
    assert again.slam.map.count == first.slam.map.count, "the same map"


@pytest.mark.parametrize(
    "feed",
    [
        Feed(1.0, float("nan"), 0.0, 0.1),
        Feed(1.0, 1e308, 0.0, 0.1),
        Feed(1.0, 0.1, 0.0, 1e308),
        Feed(float("inf"), 0.1, 0.0, 0.1),
        Feed(1.0, 0.1, 0.0, 0.1, b""),
        Feed(1.0, 0.1, 0.0, 0.1, b"\xff\xd8 cut in the middle"),
        Feed(1.0, 0.1, 0.0, 0.1, view(0.1)[:900]),
    ],
)
def test_no_feed_ends_the_brain_or_moves_it_far(mind, feed):
    walk(mind, 5)
    pose = mind.slam.map.pose()
    (answer,) = seen(mind.take(feed))
    assert answer.pose == pytest.approx(pose, abs=0.02)


def test_the_stream_of_the_cells_follows_them():
    stream, cells = CellStream(), np.zeros((36, 15, 15))
    dice, levels = np.random.default_rng(1), np.zeros(8100, int)
    for n in range(20):
        cells[:] = 0.0
        cells.reshape(-1)[dice.integers(0, 8100, 60)] = dice.random(60)
        data, key = stream.next(cells)
        assert key == (n == 0)
        told = np.frombuffer(data, "<u2").astype(int)
        levels[told >> 3] = told & 7
        assert (levels == np.rint(cells.reshape(-1) * 7 / cells.max())).all()
    assert stream.next(cells) is None
    stream.key = True
    assert stream.next(np.zeros((36, 15, 15)))[1] is True


def test_an_empty_map_is_a_packet_too(mind):
    data, key = MapStream().next(mind.slam, ())
    assert key
    assert decoded(data) == (mind.slam.map_number, {}, set(), (), (), (0, 0, 0))


def test_frames_are_read_as_written_and_a_cut_one_is_the_end(tmp_path):
    one, other = Feed(1.0, 0.1, -0.2, 0.1, b"jpeg", True), messages.Answer(3, "why", False, 4, 5.0)
    (tmp_path / "pipe").write_bytes(frame(one) + frame(other) + frame(one)[:-1])
    with (tmp_path / "pipe").open("rb") as pipe:
        assert to_brain.decode(read(pipe)) == one
        assert from_brain.decode(read(pipe)) == other
        assert read(pipe) is None


@given(st.floats(-0.3, 0.3), st.floats(-3.0, 3.0), st.floats(-3.1, 3.1))
def test_the_way_between_two_odometries(distance, turn, heading):
    """Along a circle: the chord is shorter than the arc that the robot drove."""
    half = turn / 2
    chord = distance * (np.sin(half) / half if abs(half) > 1e-9 else 1.0)
    x, y = 3.0 + chord * np.cos(heading + half), -2.0 + chord * np.sin(heading + half)
    rest = Velocity(0.0, 0.0)
    there = Odometry(x, y, float(np.arctan2(np.sin(heading + turn), np.cos(heading + turn))), rest)
    found = between(Odometry(3.0, -2.0, heading, rest), there)
    assert found == pytest.approx((distance, turn), abs=1e-6)
