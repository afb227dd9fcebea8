"""The path of a robot from above: pieces, sizes, places, pixels and words; in movies and on the pages of jobs."""

import json
from itertools import pairwise
from math import cos, dist, hypot, inf, nan, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.web.recordings.figures import ACROSS, IN_A_ROW, beside
from robots.kit.contract.floor import Floor
from robots.kit.recording import chart
from robots.kit.recording.captions import Captions, wrapped
from robots.kit.recording.chart import Chart, dashes
from robots.kit.recording.container import COMMANDS, STATE, Message
from robots.kit.recording.film import HEIGHT, TOP, VIEW, WIDTH, Film
from robots.kit.recording.floors import floor_of
from robots.kit.recording.paths import JUMP_M, lines, placed, plot_bounds, simplified
from robots.kit.recording.track import Track, pose_of

PLACES = st.tuples(st.floats(-50, 50), st.floats(-50, 50))
ANY = st.floats(allow_nan=True, allow_infinity=True)
ROOM = Floor((0.0, 0.0, 12.0, 8.0), ((2.0, 2.0, 4.0, 3.0),), ((6.0, 4.0, 0.5),))
T0 = 1_796_000_000_000  # ms


def state(at_ms, *pose):
    values = dict(zip(("x", "y", "heading"), pose, strict=False))
    return Message(STATE, at_ms * 10**6, 0, json.dumps({"values": values}).encode())


def test_a_path_is_in_pieces_where_the_robot_was_carried():
    path = [(0, 0, 0), (0.5, 0, 0), (0.5, 0.001, 0), (5, 5, 0), (5.5, 5, 0), (nan, 1, 0), (inf, 0, 0), (1e308, 0, 0)]
    assert lines(path) == [[(0, 0), (0.5, 0)], [(5, 5), (5.5, 5)]]


@given(st.lists(st.tuples(ANY, ANY, ANY), max_size=60))
def test_whatever_states_tell_a_path_has_finite_places_without_jumps(poses):
    for line in lines(poses):
        assert all(abs(v) < 1e4 for place in line for v in place)
        assert all(dist(a, b) < JUMP_M for a, b in pairwise(line))


@given(st.lists(st.lists(PLACES, max_size=300), max_size=12), st.integers(4, 80))
def test_a_path_for_a_page_is_bounded_and_keeps_its_ends(path, most):
    found = simplified(path, most)
    assert sum(map(len, found)) <= most
    whole = [line for line in path if line][: most // 2]
    assert [line[0] for line in found] == [tuple(round(v, 3) for v in line[0]) for line in whole]
    assert [line[-1] for line in found] == [tuple(round(v, 3) for v in line[-1]) for line in whole]


@given(PLACES, PLACES, st.floats(-pi, pi))
def test_a_foreseen_pose_is_placed_on_the_floor(place, start, heading):
    dx, dy = place[0] - start[0], place[1] - start[1]
    own = (cos(heading) * dx + sin(heading) * dy, cos(heading) * dy - sin(heading) * dx, 0.0)
    ((x, y),) = placed([own], (*start, heading))
    assert hypot(x - place[0], y - place[1]) < 1e-9


@given(st.lists(st.lists(PLACES, min_size=1, max_size=9), max_size=4), st.sampled_from([None, ROOM]))
def test_a_plot_shows_the_whole_path_and_the_whole_room(path, floor):
    x0, y0, x1, y1 = plot_bounds(floor, path)
    assert x1 - x0 >= 2 - 1e-9 and y1 - y0 >= 2 - 1e-9
    assert all(x0 <= x <= x1 and y0 <= y <= y1 for line in path for x, y in line)
    if floor:
        assert x0 <= 0 and y0 <= 0 and x1 >= 12 and y1 >= 8
    plot = Chart((x0, y0, x1, y1), 288, 264)
    assert all(0 <= u < 288 and 0 <= v < 264 for line in path for u, v in map(plot.at, line))


def test_up_on_the_floor_is_up_in_the_picture():
    plot = Chart((0.0, 0.0, 12.0, 8.0), 288, 264)
    assert plot.at((0, 8))[1] < plot.at((0, 0))[1] and plot.at((12, 0))[0] > plot.at((0, 0))[0]


@pytest.mark.parametrize(
    "wrong",
    [
        {"room": (0.0, 0.0, 0.0, 1.0)}, {"room": (0.0, 0.0, nan, 1.0)}, {"rectangles": ((1.0, 1.0, 0.0, 2.0),)},
        {"circles": ((0.0, 0.0, -1.0),)}, {"circles": ((inf, 0.0, 1.0),)}, {"circles": ((0.0, 0.0, 1.0),) * 501},
    ],
)  # fmt: skip
def test_a_floor_that_cannot_be_drawn_is_refused(wrong):
    with pytest.raises(ValueError, match="no part of a floor"):
        Floor(**{"room": (0.0, 0.0, 1.0, 1.0), **wrong})


def test_robots_say_how_their_floor_looks():
    hall = floor_of("srv1", {})
    assert hall.room == (0.0, 0.0, 12.0, 8.0) and len(hall.rectangles) == 6 and len(hall.circles) == 3
    assert floor_of("so101", {}) is None and floor_of("nobody", {}) is None


@given(st.lists(st.tuples(st.integers(0, 300), st.integers(0, 300)), min_size=2, max_size=8))
def test_dashes_cover_their_share_of_a_line(line):
    length = sum(dist(a, b) for a, b in pairwise(line))
    found = dashes(line, 8, 7)
    drawn = sum(dist(a, b) for a, b in found)
    assert abs(drawn - length * 8 / 15) <= 8 + 1.5 * len(found), "each end is rounded to a pixel"


def count(picture, colour):
    return int((picture == colour).all(axis=2).sum())


def film(path=((1, 1, 0), (3, 1, 0), (6, 2, 0.5)), findings=(), planned=((T0, [(1.0, 1.0), (6.0, 2.0)]),)):
    poses = tuple((T0 + 1000 * n, pose) for n, pose in enumerate(path))
    plot = {"name": "Rover", "labels": {"go": "Go to a place"}, "findings": list(findings)}
    return Film(plot, Track(poses, planned), ROOM)


@pytest.mark.parametrize(("size", "scale"), [((240, 320), 1), ((164, 193), 1), ((480, 640), 2)])
def test_a_picture_of_a_movie_has_the_plot_beside_it_and_captions_above(size, scale):
    one = film()
    frame = one.beside(np.full((*size, 3), (10, 200, 10), np.uint8))
    assert frame.shape == (HEIGHT * scale, WIDTH * scale, 3)
    picture, plot = frame[TOP * scale :, : VIEW[0] * scale], frame[TOP * scale :, VIEW[0] * scale :]
    assert count(picture, (10, 200, 10)) > 0.7 * VIEW[0] * VIEW[1] * scale**2, "as large as it fits"
    assert count(plot, chart.THING) > 100 and count(plot, chart.WALL) > 100


def test_the_plot_grows_with_the_recording():
    finding = {"at_ms": T0 + 1500, "number": 3, "place": [3.0, 1.0], "text": "light 30\xa0%"}
    one, picture, seen = film(findings=[finding]), np.zeros((240, 320, 3), np.uint8), []
    for n in range(31):
        one.follow(state(T0 + 100 * n, 1 + 0.15 * n, 1.0, 0.0))
        frame = one.beside(picture)
        plot = frame[TOP : TOP + 220, VIEW[0] :]
        seen.append((count(plot, chart.DRIVEN), count(plot, chart.TAKEN), count(frame[:TOP], (190, 190, 190))))
    driven, taken, words = zip(*seen, strict=True)
    assert driven[0] < 10 and driven[-1] > driven[15] > driven[5], "the path driven so far"
    assert taken[14] == 0 and taken[15] > 100, "the picture's place, from when it was taken"
    assert words[15] > words[14] + 100, "and what was measured there"


def test_the_path_planned_is_shown_from_its_command_on():
    one, picture = film(planned=((T0 + 500, [(1.0, 1.0), (6.0, 2.0)]),)), np.zeros((240, 320, 3), np.uint8)
    one.follow(state(T0, 1.0, 1.0, 0.0))
    before = count(one.beside(picture)[TOP : TOP + 220, VIEW[0] :], chart.PLANNED)
    one.follow(state(T0 + 600, 1.0, 1.0, 0.0))
    assert before == 0 and count(one.beside(picture)[TOP : TOP + 220, VIEW[0] :], chart.PLANNED) > 100


def stage(**told):
    return Message(COMMANDS, T0 * 10**6, 0, json.dumps(told).encode())


def test_where_a_command_takes_the_robot_is_marked_until_it_has_ended():
    one, picture = film(), np.zeros((240, 320, 3), np.uint8)

    def marked(**told):
        one.follow(stage(id=7, kind="go", **told))
        return count(one.beside(picture)[TOP : TOP + 220, VIEW[0] :], chart.TARGET)

    assert marked(state="accepted", target={}) == 0
    assert marked(state="sent", target={"words": "Go", "place": {"x": 6.0, "y": 2.0}}) > 20
    assert marked(state="failed", target={}) == 0


def test_captions_tell_time_step_and_newest_readings():
    captions = Captions([(T0 + 2000, "light 30"), (T0, "light 20"), (T0, "")], {"go": "Go to a place"})
    assert captions.at(T0 - 1) == ("2026-11-30 00:53:19 UTC", "", "")
    captions.take(stage(kind="go", state="sent"))
    assert captions.at(T0)[1:] == ("Go to a place", "00:53:20  light 20")
    captions.take(stage(kind="go", state="acknowledged", progress={"text": "step 2 of 3:\ngo South", "share": 0.3}))
    assert captions.at(T0 + 2000)[1:] == ("step 2 of 3: go South", "00:53:22  light 30")
    captions.take(stage(kind="go", state="failed", progress={"text": "step 2"}))
    assert captions.at(T0)[1] == "Go to a place: failed"


@pytest.mark.parametrize("data", [b"", b"[]", b'{"progress": 3}', b'{"progress": {"text": [1]}}', b"\xff"])
def test_what_is_no_command_says_nothing_and_ends_no_movie(data):
    captions = Captions([], {})
    captions.take(Message(COMMANDS, 0, 0, data))
    assert len(captions.at(T0)) == 3
    assert pose_of(Message(STATE, 0, 0, data)) is None


@given(st.text(max_size=200), st.integers(2, 60), st.integers(1, 4))
def test_wrapped_words_keep_to_their_lines(words, fits, most):
    found = wrapped(words, fits, most)
    assert len(found) <= most and all(len(line) <= fits for line in found)


@given(st.text(max_size=300))
def test_whatever_people_write_fits_above_the_picture(words):
    one = film()
    one.follow(stage(kind="go", state="acknowledged", progress={"text": words}))
    frame = one.beside(np.zeros((24, 32, 3), np.uint8))
    assert (frame[:TOP, 635:] == (24, 24, 24)).all(), "nothing is cut off by the edge"


@given(st.floats(12, 628), st.floats(12, 400), st.integers(1, IN_A_ROW))
def test_no_mark_of_one_place_covers_another_and_none_leaves_the_drawing(x, y, count):
    placed = beside([(n, x, y) for n in range(count)])
    assert [number for number, _, _ in placed] == list(range(count)) and placed[0] == (0, x, y)
    assert all(abs(a[1] - b[1]) >= ACROSS - 1e-6 for n, a in enumerate(placed) for b in placed[n + 1 :])
    assert all(12 <= at <= 628 for _, at, _ in placed)


def test_marks_apart_stay_where_they_are_and_of_many_at_one_place_some_are_covered():
    apart = [(1, 20.0, 20.0), (2, 20.0 + ACROSS, 20.0)]
    assert beside(apart) == tuple(apart)
    many = beside([(n, 100.0, 50.0) for n in range(9)])
    assert max(x for _, x, _ in many) == 100 + ACROSS * (IN_A_ROW - 1)
