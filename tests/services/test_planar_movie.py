"""The movie of an arm in a plane has its table from above: links and tool, the way, where a motion goes, where it worked."""

import json
from datetime import timedelta
from itertools import pairwise

import av
import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.grants import stage_event
from robots.kit.clock import SYSTEM
from robots.kit.contract.find import spec_of
from robots.kit.contract.planar import PlanarArm
from robots.kit.contract.target import target_of
from robots.kit.description import load
from robots.kit.drivers.mercury.scara import scara
from robots.kit.packets import picture_packet
from robots.kit.recording import chart
from robots.kit.recording.arm import tool_of
from robots.kit.recording.chart import Chart
from robots.kit.recording.container import COMMANDS, STATE, Message
from robots.kit.recording.film import HEIGHT, TOP, VIEW, WIDTH
from robots.kit.recording.floors import floor_of
from robots.kit.recording.marks import MOST, Marks
from robots.kit.recording.packets import picture_of
from robots.kit.recording.paths import FARTHEST, plot_bounds
from robots.models import Command, Movie, Recording, RecordingState
from robots.recordings import keeping, movies
from robots.states import CommandState, GrantKind
from tests.services.tapes import jpeg, let_make, tape_of

HERE, THERE = (-0.18, 0.34), (0.18, 0.50)
MOVE_S, AIR_S, SECONDS = 3.0, 3.5, 4.0  # the motion ends, the burst ends, the recording ends
ARM = scara(load("mercury"))
ANGLE = st.floats(-3, 3)


def at(share, height=0.0):
    """Return the joints at a share of the straight way (rad, m)."""
    x, y = (a + share * (b - a) for a, b in zip(HERE, THERE, strict=True))
    return ARM.inverse(x, y, height, 0.0)


def like(picture, colour):
    """Return how many pixels have a colour, as exactly as a movie keeps it."""
    return int((np.abs(picture.astype(int) - colour).max(axis=2) < 40).sum())


def stages(robot, grant, number, kind, args, began, seconds, sent):
    """Yield when each stage of a command was told (s), and its event, as the owner of the robot tells them."""
    command = Command.objects.create(
        robot=robot, grant=grant, client_seq=number, kind=kind, args=args, epoch=1, state=CommandState.SENT,
        created_at=began, deadline=began, sent_at=began, target=target_of(robot.spec(), kind, args),
    )  # fmt: skip
    yield 0.0, stage_event(command)
    command.state, command.ended_at, command.result = CommandState.COMPLETED, began + seconds, {"sent": sent}
    yield seconds.total_seconds(), stage_event(command)


@pytest.mark.service
@pytest.mark.django_db
@pytest.mark.parametrize("which", ["mercury"], indirect=True)
def test_a_movie_of_an_arm_in_a_plane_shows_sand_links_way_target_and_bursts(robot, people, media):
    began = SYSTEM.now()
    grant = robot.grants.create(kind=GrantKind.TURN, holder=people["ada"], opened_at=began, ended_at=began)
    recording = keeping.begin(grant, "here", began)
    x, y = THERE
    move_s, air_s = timedelta(seconds=MOVE_S), timedelta(seconds=AIR_S)
    move = stages(robot, grant, 1, "move", {"x": x, "y": y}, began, move_s, {"x": x, "y": y, "z": 0.0})
    burst = stages(robot, grant, 2, "air", {}, began, air_s, {"seconds": 0.15, "x": x, "y": y})
    told = sorted([*move, *burst], key=lambda one: one[0])
    with tape_of(recording) as (tape, began_ms):
        for n in range(int(10 * SECONDS) + 1):
            ms, second = began_ms + 100 * n, n / 10
            while told and told[0][0] <= second:
                tape.put(COMMANDS, ms * 10**6, msgspec.json.encode(told.pop(0)[1]))
            joints = dict(zip(("q1", "q2", "q3", "q4"), at(min(1.0, second / MOVE_S)), strict=True))
            tape.put(STATE, ms * 10**6, {"number": n, "at_ms": ms, "joints": joints})
            tape.put("camera/0", ms * 10**6, picture_of(picture_packet(n, ms, 0, (), jpeg(90))))
    keeping.finish(recording, RecordingState.READY, "", began + timedelta(seconds=SECONDS))
    movie = let_make(movies.ask(Recording.objects.get(pk=recording.pk), "mp4", began))
    assert (movie.state, movie.reason) == (Movie.State.READY, "")
    with av.open(str(keeping.movie_path(movie))) as file:
        frames = {round(one.time, 1): one.to_ndarray(format="rgb24") for one in file.decode(video=0)}
    assert {frame.shape for frame in frames.values()} == {(HEIGHT, WIDTH, 3)}
    plots = {when: frame[TOP : TOP + 220, VIEW[0] :] for when, frame in frames.items()}
    first, during, after, last = (plots[when] for when in (0.0, 1.5, 3.2, 4.0))
    plan = Chart(plot_bounds(floor_of("mercury", {}), [[HERE, THERE, (0.0, 0.0)]]), WIDTH - VIEW[0], VIEW[1])

    def near(plot, place, size=9):
        u, v = plan.at(place)
        return plot[v - size : v + size, u - size : u + size]

    assert like(near(first, HERE), chart.INK) > 40 > like(near(last, HERE), chart.INK), "the nozzle was here"
    assert like(near(last, THERE), chart.INK) > 20 > like(near(first, THERE), chart.INK), "and came there"
    half = ARM.forward(at(0.5))[:2]
    assert like(near(during, half), chart.INK) > 40 > like(near(first, half), chart.INK), "the map follows time"
    assert like(near(during, ARM.elbow(at(0.5))), chart.INK) > 15, "its links bend at the elbow"
    driven = [like(plot, chart.DRIVEN) for plot in (first, during, after)]
    assert driven[0] < 10 < driven[1] < driven[2], "the way so far"
    assert like(near(first, THERE), chart.TARGET) > 15 < like(near(during, THERE), chart.TARGET), "where it goes"
    assert like(near(after, THERE), chart.TARGET) == 0, "until the motion has ended"
    assert like(near(after, THERE), chart.DONE) == 0 < like(near(last, THERE), chart.DONE), "where it blew"
    sand = near(first, (0.0, 0.5), 4)
    assert like(sand, chart.THING) == sand.shape[0] * sand.shape[1], "the sand"
    recording.refresh_from_db()
    (line,) = recording.track["driven"]
    assert line[0] == pytest.approx(HERE, abs=0.002) and line[-1] == pytest.approx(THERE, abs=0.002)


@given(ANGLE, ANGLE)
def test_links_and_tool_are_where_the_kinematics_of_the_robot_say(q1, q2):
    arm, joints = spec_of("mercury").capability(PlanarArm), (q1, q2, 0.0, 0.0)
    base, elbow, tool = arm.places((q1, q2))
    assert base == (0.0, 0.0)
    assert elbow == pytest.approx(ARM.elbow(joints)) and tool == pytest.approx(ARM.forward(joints)[:2])
    named = dict(zip(("q1", "q2", "q3", "q4"), joints, strict=True))
    seen = tool_of("mercury")(Message(STATE, 0, 0, json.dumps({"joints": named}).encode()))
    assert seen.arm == (base, elbow, tool) and seen.pose[:2] == tool and seen.start == joints


@given(st.lists(st.floats(0.1, 1.0), min_size=1, max_size=6), st.data())
def test_any_number_of_links_reaches_no_farther_than_they_are_long(links, data):
    names = tuple(f"j{n}" for n in range(len(links)))
    angles = data.draw(st.lists(ANGLE, min_size=len(links), max_size=len(links)))
    places = PlanarArm(names, tuple(links)).places(angles)
    apart = [np.hypot(*np.subtract(a, b)) for a, b in pairwise(places)]
    assert apart == pytest.approx(links) and np.hypot(*places[-1]) <= sum(links) + 1e-9


@pytest.mark.parametrize(("joints", "links"), [((), ()), (("a",), ()), (("a", "b"), (1.0,))])
def test_links_that_do_not_fit_their_joints_are_refused(joints, links):
    with pytest.raises(ValueError, match="one link for each joint"):
        PlanarArm(joints, links)


VALUES = st.none() | st.booleans() | st.text(max_size=3) | st.floats() | st.integers()
PLACE = st.dictionaries(st.sampled_from(("x", "y")), VALUES)
TOLD = st.fixed_dictionaries(
    {"id": VALUES, "state": st.sampled_from(("sent", "completed", "failed")), "kind": st.just("air")},
    optional={"target": VALUES | st.fixed_dictionaries({"place": PLACE | VALUES}),
              "result": VALUES | st.fixed_dictionaries({"sent": PLACE | VALUES})},
)  # fmt: skip


@given(st.lists(st.binary(max_size=30) | TOLD.map(lambda told: json.dumps(told).encode()), max_size=20))
def test_whatever_commands_tell_marks_are_places_that_can_be_drawn(told):
    marks = Marks({"kind": "air", "label": "bursts"})
    for data in told:
        marks.take(Message(COMMANDS, 0, 0, data))
    for place in (*marks.work_places, *([marks.target] if marks.target else [])):
        assert len(place) == 2 and all(abs(v) < FARTHEST for v in place)


def test_marks_are_bounded_and_a_newer_motion_takes_the_target_over():
    marks = Marks({"kind": "air", "label": "bursts"})

    def take(**told):
        marks.take(Message(COMMANDS, 0, 0, json.dumps(told).encode()))

    for n in range(MOST + 9):
        take(id=n, kind="air", state="completed", result={"sent": {"x": 0.1, "y": 0.2}})
    assert len(marks.work_places) == MOST
    take(id=1, kind="move", state="sent", target={"place": {"x": 1, "y": 2}})
    take(id=2, kind="move", state="sent", target={"place": {"x": 3, "y": 4}})
    take(id=1, kind="move", state="completed", target={})
    assert marks.target == (3.0, 4.0)
    take(id=2, kind="move", state="rejected", target={})
    assert marks.target is None
