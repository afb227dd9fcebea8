"""The movie of an arm has its table from above: the way of its tool, the way planned, base and tool, what is forbidden."""

import json
from datetime import timedelta
from math import dist

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.arms.described import chain
from robots.kit.clock import SYSTEM
from robots.kit.contract.find import spec_of
from robots.kit.packets import picture_packet
from robots.kit.recording import chart
from robots.kit.recording.arm import table_of, tool_of
from robots.kit.recording.container import STATE, Message
from robots.kit.recording.film import TOP
from robots.kit.recording.floors import floor_of
from robots.kit.recording.packets import picture_of
from robots.models import Command, Movie, Recording, RecordingState
from robots.recordings import keeping, movies
from robots.states import CommandState, GrantKind
from tests.services.tapes import jpeg, let_make, tape_of

ARMS = ("pa10", "puma")
BEGIN, END = (0.0, 0.44, 1.31, 0.0, 1.4, 0.0, 0.05), (0.8, 0.44, 1.31, 0.0, 1.4, 0.0, 0.05)
SECONDS = 4
SHARES = np.linspace(0.0, 1.0, 10 * SECONDS + 1)


def told(names, joints, at_ms=0):
    state = {
        "number": 1,
        "at_ms": at_ms,
        "moving": True,
        "stopped": False,
        "mode": "",
        "joints": dict(zip(names, joints, strict=False)),
    }
    return json.dumps(state).encode()


def like(picture, colour):
    """Return how many pixels have a colour, as exactly as a movie keeps it."""
    return int((np.abs(picture.astype(int) - colour).max(axis=2) < 40).sum())


@pytest.mark.service
@pytest.mark.django_db
@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_a_movie_of_an_arm_shows_where_its_tool_goes_over_its_table(robot, people, media):
    began, spec = SYSTEM.now(), robot.spec()
    grant = robot.grants.create(kind=GrantKind.TURN, holder=people["ada"], opened_at=began, ended_at=began)
    args = {name: value for name, value in zip(spec.joints, END[:6], strict=False)} | {"speed": 1.0}
    Command.objects.create(
        robot=robot, grant=grant, client_seq=1, kind="joints", args=args, epoch=1, state=CommandState.COMPLETED,
        created_at=began, deadline=began, sent_at=began + timedelta(seconds=0.5), ended_at=began,
    )  # fmt: skip
    recording = keeping.begin(grant, "here", began)
    with tape_of(recording) as (tape, began_ms):
        for n, share in enumerate(SHARES):
            ms = began_ms + 100 * n
            joints = [a + share * (b - a) for a, b in zip(BEGIN, END, strict=True)]
            tape.put(STATE, ms * 10**6, json.loads(told(spec.joints, joints, ms)))
            tape.put("camera/0", ms * 10**6, picture_of(picture_packet(n, ms, 0, (), jpeg(90))))
    keeping.finish(recording, RecordingState.READY, "", began + timedelta(seconds=SECONDS))
    movie = let_make(movies.ask(Recording.objects.get(pk=recording.pk), "mp4", began))
    assert (movie.state, movie.reason) == (Movie.State.READY, "")
    with av.open(str(keeping.movie_path(movie))) as file:
        frames = [one.to_ndarray(format="rgb24") for one in file.decode(video=0)]
    first, last = (frame[TOP : TOP + 220, 352:] for frame in (frames[0], frames[-1]))
    assert last.shape == (220, 288, 3)
    assert like(last, chart.DRIVEN) > like(first, chart.DRIVEN) + 40, "the way so far"
    early = frames[len(frames) // 4][TOP : TOP + 220, 352:]
    assert like(early, chart.PLANNED) > 60 > like(first, chart.PLANNED), "the way planned, before it is covered"
    assert like(last, chart.THING) > 100, "what is forbidden"
    assert like(last, chart.INK) > 60, "base and tool"
    assert like(frames[-1][:TOP], (190, 190, 190)) > 50, "the time"
    recording.refresh_from_db()
    at_command = (BEGIN[0] + (END[0] - BEGIN[0]) / 8, *BEGIN[1:])
    driven, planned = (recording.track[name][0] for name in ("driven", "planned"))
    assert dist(driven[0], tool(BEGIN)) < 0.005 and dist(planned[0], tool(at_command)) < 0.005
    assert dist(driven[-1], tool(END)) < 0.005 and dist(planned[-1], tool(END)) < 0.005


def tool(joints):
    x, y, _ = chain("pa10").forward(np.array(joints[:6]))[:3, 3]
    return float(x), float(y)


@pytest.mark.parametrize("driver", ARMS)
def test_the_tool_is_where_the_joints_of_a_state_say(driver):
    names = spec_of(driver).joints
    joints = [0.1 * n for n in range(len(names))]
    (x, y, _), start, _ = tool_of(driver)(Message(STATE, 0, 0, told(names, joints)))
    arm = chain(driver)
    assert dist((x, y), arm.forward(np.array(joints[: len(arm.names)]))[:2, 3]) < 1e-9
    assert start == tuple(joints), "a preview begins from all of them"


@pytest.mark.parametrize("driver", ARMS)
@given(data=st.binary(max_size=60) | st.dictionaries(st.text(max_size=3), st.none() | st.text() | st.floats()).map(
    lambda joints: json.dumps({"joints": joints}).encode()))  # fmt: skip
def test_what_tells_no_joints_tells_no_place(driver, data):
    assert tool_of(driver)(Message(STATE, 0, 0, data)) is None


@pytest.mark.parametrize("driver", ARMS)
def test_a_table_is_the_largest_box_and_the_others_stand_on_it_those_of_staff_too(driver):
    own = table_of(driver, {})
    assert own == floor_of(driver, {})
    width = own.room[2] - own.room[0]
    assert all(x1 - x0 < width for x0, _, x1, _ in own.rectangles)
    assert any(x0 < 0 < x1 and y0 < 0 < y1 for x0, y0, x1, y1 in own.rectangles), "the base"
    box = {"name": "a wall", "low": [0.4, 0.2, 0.0], "high": [0.5, 0.3, 0.4]}
    assert (0.4, 0.2, 0.5, 0.3) in table_of(driver, {"boxes": [box]}).rectangles


def test_a_robot_that_neither_rolls_nor_is_an_arm_has_none():
    assert floor_of("so101", {}) is None
