"""A spec that contradicts itself is refused when it is created, with a sentence that names the error."""

import json
from dataclasses import replace
from math import inf
from struct import unpack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.capabilities import (
    GoodWhile,
    Idle,
    JobCheck,
    Need,
    Programs,
    Setting,
    Share,
    Statistics,
    Times,
    Total,
)
from robots.kit.contract.channels import IN_PLANE, MOST, Pose, Scalar, finite, whole
from robots.kit.contract.find import spec_of
from robots.kit.contract.policies import Bound, Policies, Range
from robots.kit.contract.session import RobotState
from robots.kit.contract.spec import ANYONE, STAFF, Argument, CommandKind, Spec
from robots.kit.contract.streams import Stream
from robots.kit.packets import read_state, state_packet

GO = CommandKind("go", "Go", (Argument("x", "m", 0.0, 1.0),))
PACE = CommandKind(
    "pace", "Pace", (Argument("pace", "m/s", 0.0, 1.0),), lane="config", default={"pace": 0.5}, moves=False
)
CHARGE = Scalar("charge", "%", 0.0, 100.0)
FAST = Setting("fast", "Fast", unit="m/s", low=0.1, high=0.5, default=0.3)
SOUND = Spec("Cart", (GO, PACE), ("wheel",), ("go",), (CHARGE,), (Idle("go"), Need("go", "charge", 20.0, 90.0)))


def alone(seconds, name="wheel"):
    return Policies(on_link_lost=Bound(seconds, (Range(name, 0.0, 1.0),)))


def by_setting(name):
    return Policies(on_link_lost=Bound(5.0, setting=name))


LONG = Setting("long_s", "Alone", unit="s", low=0.0, high=15.5, default=5.0)
TURNS = replace(GO, policies=Policies(on_grant_end=Bound(1.0, turn=0.5)))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"commands": (GO, GO)}, "names the command 'go' twice"),
        ({"joints": ("wheel", "wheel")}, "'wheel' twice"),
        ({"joints": ("charge",)}, "names the joint, coordinate or channel 'charge' twice"),
        ({"channels": (CHARGE, CHARGE)}, "'charge' twice"),
        ({"handover": ("home",)}, "no command 'home', which its handover names"),
        ({"handover": ("pace",)}, "of the lane 'config' in its handover"),
        ({"capabilities": (Idle("roam"),)}, "no command 'roam', which its Idle names"),
        ({"capabilities": (Idle("pace"),)}, "names 'pace' of the lane 'config' in its Idle"),
        ({"capabilities": (Programs("run", "text"),)}, "no command 'run', which its Programs names"),
        ({"capabilities": (Statistics(over_time="fuel"),)}, "no channel 'fuel', which its Statistics names"),
        ({"capabilities": (Statistics(rows=(Total("Driven", "way"),)),)}, "no channel 'way', which its Statistics names"),
        ({"capabilities": (Statistics(rows=(Times("Docked", "dock"),)),)}, "no command 'dock', which its Statistics names"),
        ({"capabilities": (Statistics(rows=(Share("Busy", ("go", "x")),)),)}, "no command 'x', which its Statistics names"),
        ({"capabilities": (Statistics(ends=(("a", "A"), ("a", "B"))),)}, "names the end 'a' twice in its Statistics"),
        ({"capabilities": (GoodWhile("dock", "x", "charge", "old", "Old."),)}, "no command 'dock', which its GoodWhile names"),
        ({"capabilities": (GoodWhile("go", "y", "charge", "old", "Old."),)}, "no number 'y' in its command 'go', which its"),
        ({"capabilities": (GoodWhile("go", "x", "map", "old", "Old."),)}, "no channel 'map', which its GoodWhile names"),
        ({"capabilities": (GoodWhile("go", "x", "charge", "", "Old."),)}, "gives no code for the end of jobs in its Good"),
        ({"capabilities": (JobCheck("map", "a.b:c"),)}, "has no stream 'map', which its JobCheck names"),
        ({"capabilities": (Need("dock", "charge", 20.0, 90.0),)}, "no command 'dock', which its Need names"),
        ({"capabilities": (Need("go", "battery", 20.0, 90.0),)}, "no channel 'battery', which its Need names"),
        ({"capabilities": (Need("go", "charge", 90.0, 20.0),)}, "begins below 90 and ends at 20"),
        ({"capabilities": (Need("go", "charge", float("nan"), 20.0),)}, "begins below nan"),
        ({"commands": (replace(GO, arguments=GO.arguments * 2), PACE)}, "names the argument 'x' twice in its command"),
        ({"commands": (replace(GO, arguments=(Argument("x", "m", 1.0, 0.0),)), PACE)}, "gives the argument 'x' no range"),
        ({"commands": (GO, replace(PACE, moves=True))}, "moves something, holds it or replaces it in the lane 'config'"),
        ({"commands": (GO, replace(PACE, default=None))}, "has no default that handover could restore"),
        ({"commands": (GO, replace(PACE, default={}))}, "has no default for the argument 'pace' in its command 'pace'"),
        ({"commands": (GO, replace(PACE, default={"pace": 9.0}))}, "a default for 'pace' that is out of its range"),
        ({"commands": (replace(GO, arguments=(Argument("x", "m", 0.0, inf),)), PACE)}, "gives the argument 'x' no range"),
        ({"channels": (replace(CHARGE, high=inf),)}, "gives the channel 'charge' no range"),
        ({"channels": (replace(CHARGE, low=200.0),)}, "gives the channel 'charge' no range"),
        ({"streams": (Stream("map"), Stream("map"))}, "names the stream 'map' twice"),
        ({"streams": tuple(Stream(f"s{n}") for n in range(9))}, "has 9 streams; at most 8 are possible"),
        ({"capabilities": (FAST, FAST)}, "names the setting 'fast' twice"),
        ({"capabilities": (replace(FAST, name="token"),)}, "names the setting 'token' twice"),
        ({"capabilities": (replace(FAST, high=inf),)}, "gives the setting 'fast' no range"),
        ({"capabilities": (replace(FAST, default=9.0),)}, "a default for the setting 'fast' that is out of its range"),
        ({"capabilities": (Setting("walls", "Walls", "list"),)}, "has no check of the setting 'walls'"),
        ({"rest_s": -1.0}, "rests by itself after -1 s"),
        ({"rest_s": inf}, "rests by itself after inf s"),
        ({"pose": Pose(("x", "wheel"))}, "names the joint, coordinate or channel 'wheel' twice"),
        ({"commands": (GO, replace(PACE, asked_by=frozenset({ANYONE})))}, "jobs change no settings, in its command"),
        ({"commands": (GO, replace(PACE, default={"speed": 1.0}))}, "a default for 'speed', which is no argument"),
        ({"commands": (GO, replace(PACE, shown={"speed": "charge"}))}, "shows 'speed', which is no argument, in its command"),
        ({"commands": (GO, replace(PACE, shown={"pace": "pace"}))}, "shows a value as 'pace', which no state tells"),
        ({"commands": (GO, replace(PACE, arguments=(replace(PACE.arguments[0], text=True),), shown={"pace": "charge"}))},
         "shows the text 'pace' and has no number for it, in its command"),
        ({"commands": (replace(GO, arguments=PACE.arguments, shown={"pace": "charge"}, held=True), PACE)},
         "shows 'pace' at the end of a held motion, which has none, in its command 'go'"),
        ({"commands": (replace(GO, policies=alone(99.0)), PACE)}, "go on for 99 s, which is not within its time limit"),
        ({"commands": (replace(GO, policies=alone(5.0, "tail")), PACE)}, "bounds 'tail', which no state tells"),
        ({"commands": (replace(GO, policies=by_setting("fast")), PACE)}, "is bounded by 'fast', which is no setting"),
        ({"commands": (replace(GO, policies=by_setting("long_s")), PACE), "capabilities": (LONG,)},
         "is bounded by 'long_s', which is no setting from 0 s to its time limit, in its command 'go'"),
        ({"commands": (TURNS, PACE)}, "bounds how fast it turns, and has no pose with an angle, in its command 'go'"),
        ({"commands": (TURNS, PACE), "pose": Pose(("x", "y"))}, "bounds how fast it turns, and has no pose with an angle"),
        ({"commands": (replace(GO, held=True, policies=alone(5.0)), PACE)}, "has policies although it is held"),
        (
            {"commands": (replace(GO, held=True, asked_by=frozenset({ANYONE})), PACE)},
            "may be asked for as a job, and nobody holds the controls of a job, in its command 'go'",
        ),
        ({"handover": ("go",), "commands": (replace(GO, held=True), PACE)}, "names the held motion 'go' in its handover"),
        ({"commands": (replace(GO, limit_s=0.0), PACE)}, "has no time limit in its command 'go'"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused_in_one_sentence(change, said):
    with pytest.raises(ValueError, match="The spec of 'Cart'") as refused:
        replace(SOUND, **change)
    assert said in str(refused.value)
    assert str(refused.value).endswith(".")


def test_a_robot_with_a_heading_may_bound_how_fast_it_turns():
    assert replace(SOUND, commands=(TURNS, PACE), pose=IN_PLANE).commands == (TURNS, PACE)


def test_only_settings_that_are_declared_reach_the_driver_and_only_within_their_range():
    cart = replace(SOUND, capabilities=(FAST, Setting("walls", "Walls", "list", check="m:f")))
    for kept, told in (
        ({"fast": 0.2, "slow": 3, "walls": [1]}, {"fast": 0.2, "walls": [1]}),
        ({"fast": 9, "walls": []}, {"fast": 0.5}),
        ({"fast": True, "walls": "x"}, {}),
        ({"fast": float("nan")}, {}), ({"fast": "0.2"}, {}), ({}, {}), ({"fast": 10**400}, {"fast": 0.5}),
    ):  # fmt: skip
        assert cart.for_driver(kept) == told
    assert SOUND.for_driver({"fast": 0.2}) == {}


def test_what_staff_alone_set_needs_no_default():
    assert replace(SOUND, commands=(GO, replace(PACE, default=None, asked_by=frozenset({STAFF})))).commands


def test_what_a_state_tells_is_known_by_name_and_packed_where_it_is_declared():
    state = RobotState(0.0, (0.5,), (1.0, 2.0, 0.3), False, True, values={"charge": 80.0})
    rover = replace(SOUND, pose=IN_PLANE)
    told = {"wheel": 0.5, "x": 1.0, "y": 2.0, "heading": 0.3, "charge": 80.0}
    assert rover.named(state) == told
    assert [(c.name, c.unit) for c in rover.packed()] == [("charge", "%"), ("x", "m"), ("y", "m"), ("heading", "rad")]
    assert replace(SOUND, pose=Pose(("x",), packed=False)).packed() == SOUND.packed() == (CHARGE,)
    assert SOUND.named(state) == {"wheel": 0.5, "charge": 80.0}, (
        "no pose is invented, and none shown that is not declared"
    )
    packet = state_packet(1, 0, state, False, rover.packed(), rover.named(state))
    assert unpack("<B4f", packet[20:]) == (4, 80.0, 1.0, 2.0, pytest.approx(0.3))


def test_packets_of_a_robot_with_a_pose_tell_it_with_each_picture_and_its_velocity_with_both():
    rover = replace(SOUND, pose=IN_PLANE)
    state = RobotState(0.0, (0.5,), (1.0, 2.0, 0.25), True, True, values={"charge": 80.0}, twist=(0.5, 0.0, -0.125))
    packet = state_packet(1, 0, state, False, rover.packed(), rover.named(state), rover.body(state))
    assert unpack("<B7f", packet[20:]) == (7, 80.0, 1.0, 2.0, 0.25, 0.5, 0.0, -0.125)
    read = read_state(packet, rover.packed())
    assert (read.twist, read.values["heading"]) == (state.twist, 0.25)
    assert rover.posture(state) == (0.5, 1.0, 2.0, 0.25, 0.5, 0.0, -0.125)
    assert rover.posture(replace(state, twist=())) == (0.5, 1.0, 2.0, 0.25), "a velocity that is not told is not sent"


@pytest.mark.parametrize(
    ("change", "pose", "twist", "told"),
    [
        ({"pose": None}, (1.0, 2.0, 0.25), (0.5, 0.0, 0.0), (0.5,)),
        ({"pose": replace(IN_PLANE, packed=False)}, (1.0, 2.0, 0.25), (0.5, 0.0, 0.0), (0.5,)),
        ({"pose": IN_PLANE}, (1.0,), (0.5,), (0.5,)),
        ({"pose": IN_PLANE, "joints": ("wheel", "tail")}, (1.0, 2.0, 0.25), (), (0.5,)),
    ],
)  # fmt: skip
def test_no_picture_tells_a_pose_that_the_spec_does_not_declare_or_the_state_does_not_know(change, pose, twist, told):
    state = RobotState(0.0, (0.5,), pose, True, True, twist=twist)
    assert replace(SOUND, **change).posture(state) == told


@pytest.mark.parametrize(
    ("other", "m", "rad"),
    [((1.0, 2.0, 3.1), 0.0, 0.0), ((4.0, 6.0, 3.1), 5.0, 0.0), ((1.0, 2.0, -3.1), 0.0, 0.0832), ((1, 2, 9.6), 0, 0.2168)],
)  # fmt: skip
def test_two_places_lie_apart_in_metres_and_at_most_half_a_turn(other, m, rad):
    assert IN_PLANE.apart((1.0, 2.0, 3.1), other) == (pytest.approx(m), pytest.approx(rad, abs=1e-3))
    assert IN_PLANE.apart(other, (1.0, 2.0, 3.1)) == (pytest.approx(m), pytest.approx(rad, abs=1e-3))


@pytest.mark.parametrize("wild", [float("nan"), float("inf"), -1e308, 1e308])
def test_wild_numbers_are_packed_as_not_known_and_kept_nowhere(wild):
    state = RobotState(0.0, (wild,), (wild, 1.0), False, True, values={"charge": wild})
    packet = state_packet(1, 0, state, False, SOUND.packed(), SOUND.named(state))
    assert unpack("<fBf", packet[16:]) == (
        pytest.approx(float("nan"), nan_ok=True),
        1,
        pytest.approx(float("nan"), nan_ok=True),
    )
    json.loads(json.dumps([whole(state.joints), whole(state.pose), finite(state.values)]), parse_constant=pytest.fail)


@given(st.integers(0, 2 * MOST))
def test_as_many_channels_as_a_byte_counts(count):
    channels = tuple(Scalar(f"c{i}", "", 0.0, 1.0) for i in range(count))
    if count <= MOST:
        assert Spec("Many", (), channels=channels).channels == channels
    else:
        with pytest.raises(ValueError, match=f"has {count} channels"):
            Spec("Many", (), channels=channels)


@given(st.lists(st.sampled_from("abcdef")), st.lists(st.sampled_from("abcdef"), max_size=3))
def test_a_spec_is_refused_exactly_where_a_name_stands_twice_or_is_missing(kinds, handover):
    sound = len(set(kinds)) == len(kinds) and set(handover) <= set(kinds)
    commands = tuple(CommandKind(kind, kind) for kind in kinds)
    if sound:
        assert Spec("Any", commands, handover=tuple(handover)).handover == tuple(handover)
    else:
        with pytest.raises(ValueError, match="The spec of 'Any'"):
            Spec("Any", commands, handover=tuple(handover))


@pytest.mark.parametrize("name", ["mercury", "pa10"])
def test_the_standing_robots_are_sound(name):
    assert spec_of(name).commands


@pytest.mark.parametrize(
    ("kind", "kept", "seconds"),
    [("go", {}, 6.0), ("go", {"long_s": 9}, 10.0), ("go", {"long_s": 0}, 1.0), ("pace", {}, 1.0), ("none", {}, 1.0)],
)
def test_a_robot_that_may_go_on_by_itself_rests_later(kind, kept, seconds):
    alone_s = replace(LONG, high=15.0)
    commands = (replace(GO, policies=by_setting("long_s")), PACE)
    cart = replace(SOUND, commands=commands, capabilities=(alone_s,), rest_s=1.0)
    assert cart.rests_within(kind, kept) == seconds
    assert replace(cart, rest_s=None).rests_within(kind, kept) is None


def test_what_began_before_a_setting_was_changed_rests_by_the_longest_at_the_latest():
    commands = (replace(GO, policies=by_setting("long_s")), PACE)
    cart = replace(SOUND, commands=commands, capabilities=(replace(LONG, high=15.0),), rest_s=1.0)
    assert (cart.rests_within("go", None), cart.rests_within("pace", None)) == (16.0, 1.0)
