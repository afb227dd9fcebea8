"""The iRat's composites: packets as the brain streams them, decoded and drawn; whatever comes, a picture or a sentence."""

import struct
from dataclasses import replace
from math import inf, nan

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.stream_bytes import ssim
from portal.web.composites.drawing import EVERY_S, compressed
from robots.kit.contract.channels import IN_PLANE
from robots.kit.contract.find import function, spec_of
from robots.kit.contract.session import RobotState
from robots.kit.drivers.irat.brain.streams import CellStream
from robots.kit.drivers.irat.composites.decoding import SHAPE, MapShown, silent, with_cells, with_map
from robots.kit.drivers.irat.composites.drawing import DOCK, ROBOT, draw_camera, draw_cells, draw_map
from robots.kit.drivers.irat.composites.scene import Scene, goals_of
from robots.kit.drivers.irat.packets import DOCKS, HEAD, ROUTE, VERSION
from robots.kit.packets import picture_packet, read_picture, read_state, state_packet
from simulators.irat.cameras import RobotCamera, Stage, jpeg
from simulators.irat.maze import along_corridors
from tests.unit.test_irat_brain import Mind, decoded, packets, walk

SPEC = spec_of("irat")
VALUES = {"battery": 7.9, "charge": 64.0, "x": 0.2, "y": 0.1, "heading": 0.5}
STATE = RobotState(0.0, (), (), True, True, mode="going to somebody's goal", values=VALUES)


def packet(ids, places, links=(), route=None, docks=None, number=3):
    flags = ROUTE * (route is not None) + DOCKS * (docks is not None)
    data = HEAD.pack(VERSION, flags, number, len(ids), len(links)) + np.array(ids, "<u4").tobytes()
    data += np.array(places, "<i2").reshape(-1, 2).T.tobytes() + np.array(links, "<u4").tobytes()
    for told in (route, docks):
        if told is not None:
            data += struct.pack("<H", len(told)) + np.array(told, "<u4").tobytes()
    return data


RING = packet([1, 2, 3, 9], [(0, 0), (100, 0), (100, 100), (0, 100)], [(1, 2), (2, 3), (3, 9), (7, 8)], [1, 2, 3], [9])


def coloured(part, colour, least=6):
    return int((np.abs(part.astype(int) - colour).max(axis=2) < 40).sum()) >= least


def test_what_the_brain_streams_is_decoded_alike_by_two_readers(tmp_path):
    mind = Mind(tmp_path / "brain")
    shown, known = MapShown(), None
    told = packets(walk(mind, 60))
    assert len(told) > 10
    for one in told:
        shown = with_map(shown, one.data, one.key)
        known = decoded(one.data, None if one.key else known)
    number, places, links, route, docks, dock = known
    assert shown.number == number
    assert shown.ids.tolist() == sorted(places)
    assert np.allclose(shown.places, [np.array(places[i]) * 0.005 for i in sorted(places)])
    assert {tuple(pair) for pair in shown.links.tolist()} == links
    assert (tuple(shown.route.tolist()), tuple(shown.docks.tolist())) == (route, docks)
    assert shown.dock is None
    assert dock == (0, 0, 0)


def test_a_place_that_moves_is_told_again_and_a_key_packet_forgets_everything():
    shown = with_map(with_map(MapShown(), RING, True), packet([2, 5], [(50, 0), (7, 7)]), False)
    assert shown.ids.tolist() == [1, 2, 3, 5, 9]
    assert shown.where(np.array([2])).tolist() == [[0.25, 0.0]]
    assert shown.route.tolist() == [1, 2, 3], "what a delta does not list stays"
    assert len(shown.ends()) == 3, "a link to an unknown place is left out"
    assert with_map(shown, packet([], []), True).ids.tolist() == []


@given(st.integers(0, 99), st.integers(0, 8100), st.integers(0, 8099))
def test_cells_are_decoded_as_they_were_streamed(seed, active, place):
    stream, dice = CellStream(), np.random.default_rng(seed)
    cells = dice.permutation(np.where(np.arange(8100) < active, dice.random(8100), 0.0)).reshape(SHAPE)
    shown = with_cells(silent(), *stream.next(cells))
    changed = cells.copy()
    changed.reshape(-1)[place] = 0.0
    told = stream.next(changed)
    shown = shown if told is None else with_cells(shown, *told)
    assert np.array_equal(shown, np.rint(changed * (7 / max(changed.max(), 1e-300))).astype(np.uint8))


@given(st.binary(max_size=200), st.booleans())
def test_any_bytes_are_a_map_or_a_sentence(data, key):
    for read, shown in ((with_map, with_map(MapShown(), RING, True)), (with_cells, silent())):
        try:
            read(shown, data, key)
        except ValueError as error:
            assert str(error)


@pytest.mark.parametrize("cut", range(0, len(RING), 3))
def test_a_map_cut_in_the_middle_is_refused(cut):
    with pytest.raises(ValueError):
        with_map(MapShown(), RING[:cut], True)


def test_counts_that_no_packet_holds_are_refused():
    with pytest.raises(ValueError):
        with_map(MapShown(), HEAD.pack(VERSION, 0, 1, 2**32 - 1, 2**32 - 1), True)
    with pytest.raises(ValueError):
        with_map(MapShown(), HEAD.pack(VERSION + 1, 0, 1, 0, 0), True)
    with pytest.raises(ValueError):
        with_cells(silent(), struct.pack("<H", 8100 << 3), False)


def test_the_map_shows_route_docks_goals_and_the_robot():
    shown = with_map(MapShown(), RING, True)
    part = draw_map(shown, (0.25, 0.25, 0.0), [(0, 0.5, 0.5)], 380, 400)
    for colour in (DOCK, ROBOT, (60, 60, 235)):
        assert coloured(part, np.array(colour)), colour
    bare = replace(shown, route=shown.route[:0], docks=shown.docks[:0])
    without = draw_map(bare, None, [], 380, 400)
    assert coloured(draw_map(replace(bare, dock=(0.1, 0.1, 0.42)), None, [], 380, 400), np.array(DOCK), 40)
    for colour in (DOCK, ROBOT, (60, 60, 235)):
        assert not coloured(without, np.array(colour)), colour


@given(st.tuples(*[st.floats() | st.sampled_from([nan, inf, 1e308])] * 5))
def test_no_pose_and_no_goal_is_too_odd_to_be_drawn(odd):
    shown = with_map(MapShown(), RING, True)
    assert draw_map(shown, odd[:3], [(0, odd[3], odd[4])], 120, 90).shape == (90, 120, 3)


def test_more_active_cells_are_drawn_brighter():
    weak, strong = silent(), silent()
    weak[18, 7, 7], strong[18, 7, 7] = 1, 7
    sums = [int(draw_cells(levels, 360, 190).sum()) for levels in (silent(), weak, strong)]
    assert sums == sorted(set(sums))


def test_a_picture_that_is_none_leaves_words():
    view = cv2.imencode(".jpg", np.full((240, 416, 3), (30, 90, 200), np.uint8))[1].tobytes()
    assert np.abs(draw_camera(view, 208, 120)[60, 104].astype(int) - (30, 90, 200)).max() < 12
    for broken in (None, b"", b"\xff\xd8nonsense", view[:40]):
        assert draw_camera(broken, 208, 120).shape == (120, 208, 3)


@pytest.mark.parametrize("size", [(780, 460), (320, 480)])
def test_a_composite_has_the_papers_size_whatever_is_known(size):
    scene = Scene(*size)
    empty = scene.draw(None, None, [])
    scene.take("map", RING, True)
    scene.take("cells", struct.pack("<H", 4000 << 3 | 7), True)
    assert scene.draw(None, replace(STATE, values={}, mode="größer"), []).shape == empty.shape
    full = scene.draw(b"", STATE, [{"map": 3, "x": 0.5, "y": 0.5}, {"map": 2, "x": 0.1, "y": 0.1}, {"x": "a"}])
    assert empty.shape == full.shape == (size[1], size[0], 3)
    assert empty.dtype == full.dtype == np.uint8
    assert (empty != full).any()


def test_only_goals_of_this_map_are_shown_with_their_turn():
    here = {"map": 3, "x": 1, "y": 2}
    jobs = [{**here, "map": 2}, here, {**here, "x": nan}, {"map": 3}, {}, {**here, "experience": 2.0}]
    jobs += [{**here, "experience": odd} for odd in (77, nan, 1e308, "2")]
    shown = with_map(MapShown(), RING, True)
    at_its_place = (5, 0.5, 0.0)  # of experience 2, wherever it was asked for
    assert list(goals_of(jobs, shown)) == [(1, 1.0, 2.0), at_its_place, *((n, 1.0, 2.0) for n in range(6, 10))]


def test_the_spec_names_scenes_that_exist():
    declared = [c for c in SPEC.capabilities if hasattr(c, "scene")]
    assert [(c.width, c.height) for c in declared] == [(780, 460), (320, 480)]
    assert all(function(c.scene) is Scene for c in declared)


@given(
    st.dictionaries(st.sampled_from(["battery", "x", "heading", "other"]), st.floats(width=32)), st.text(max_size=20)
)
def test_a_state_is_read_as_it_was_packed(values, mode):
    told = RobotState(0.0, (), (0.5, 1.5, -1.0), True, True, mode=mode, values=values)
    read = read_state(state_packet(7, 12_345, told, False, SPEC.packed(), SPEC.named(told)), SPEC.packed())
    assert (read.at, read.moving, read.mode) == (12.345, True, mode)
    expected = {name: v for name, v in SPEC.named(told).items() if name != "other" and abs(v) < 3.4e38}
    assert read.values == expected
    assert set(IN_PLANE.coordinates) <= set(read.values) | set(values)


@given(st.binary(max_size=80))
def test_any_bytes_are_a_state_and_a_picture_or_a_sentence(data):
    for read in (lambda: read_state(data, SPEC.packed()), lambda: read_picture(data)):
        try:
            read()
        except ValueError as error:
            assert str(error).startswith("not a packet")


def test_a_picture_is_what_was_packed():
    assert read_picture(picture_packet(1, 2, 3, (0.5, 1.0), b"JPEG")) == b"JPEG"


def roaming():
    """Yield what a robot shows that has driven each corridor four times, at places of the maze: picture, x, y, heading.

    The first is the packet of its map, with about 1700 experiences.
    """
    dice, camera = np.random.default_rng(4), RobotCamera(Stage())
    driven = np.concatenate([along_corridors(0.02)[:, :2] + dice.normal(0, 0.006, 2) for _ in range(4)])
    ids = list(range(len(driven)))
    links = [(i, i + 1) for i in ids[:-1] if np.hypot(*(driven[i + 1] - driven[i])) < 0.1]
    yield packet(ids, (driven / 0.005).astype("<i2"), links, ids[:30], ids[90:100])
    for x, y, heading in along_corridors(0.25)[::4].tolist():
        hull = np.eye(4)
        hull[:2, :2] = [[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]]
        hull[:2, 3] = x, y
        yield jpeg(camera.take(hull)), x, y, heading


def test_plain_video_needs_no_more_bits_than_the_papers_and_looks_like_what_was_drawn():
    """1.5 Mbit/s for a desktop, 0.8 for a phone."""
    told, *seen = roaming()
    for width, height, most in ((780, 460, 1.5e6), (320, 480, 0.8e6)):
        scene = Scene(width, height)
        scene.take("map", told, True)
        drawn = [
            scene.draw(picture, replace(STATE, values=VALUES | {"x": x, "y": y, "heading": heading}), [])
            for picture, x, y, heading in seen
        ]
        sent = [compressed(pixels) for pixels in drawn]
        assert 8 * np.mean([len(data) for data in sent]) / EVERY_S <= most
        alike = [
            ssim(pixels, cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR))
            for pixels, data in zip(drawn, sent, strict=True)
        ]
        assert np.mean(alike) >= 0.95
