"""What a command does in words: every command of every robot, whatever its arguments are."""

from dataclasses import replace
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.channels import IN_PLANE, IN_SPACE
from robots.kit.contract.find import spec_of
from robots.kit.contract.spec import Argument, CommandKind, Spec
from robots.kit.contract.words import NAMED, called, command_words, place_of, place_words, quantity, way_words

X, Y = (
    Argument("x", "m", -9.0, 9.0, directions=("right", "left")),
    Argument("y", "m", -9.0, 9.0, directions=("up", "down")),
)
WAY = (
    Argument("dx", "", -1.0, 1.0, directions=("right", "left")),
    Argument("dy", "", -1.0, 1.0, directions=("up", "down")),
)
ANGLE = Argument("angle", "rad", -4.0, 4.0, label="to the left", directions=("to the left", "to the right"))
CART = Spec(
    "Cart",
    (
        CommandKind("go", "Go", (X, Y)), CommandKind("jog", "Jog", WAY, held=True), CommandKind("turn", "Turn", (ANGLE,)),
        CommandKind("beep", "Beep", (Argument("seconds", "s", 0.0, 9.0, required=False),), says="Beep[ for {seconds}]"),
        CommandKind("say", "Say", (Argument("text", "", 1, 9000, text=True),)),
        CommandKind("far", "Go to a place", (Argument("wall", "m", 0.0, 9.0, label="from the left wall"),)),
        CommandKind("turns", "Turn around", (Argument("times_over", "", 0.0, 9.0),)),
    ),
    pose=IN_PLANE,
)  # fmt: skip
HERE = {"x": 0.0, "y": 0.42, "heading": 0.0}


@pytest.mark.parametrize(
    ("kind", "args", "before", "words"),
    [
        ("go", {"x": 0.12, "y": 0.46}, HERE, "Go to 12 cm right, 4 cm up"),
        ("go", {"x": -1.5, "y": 0.42}, HERE, "Go to 1.5 m left"),
        ("go", {"x": 0.0, "y": 0.4201}, HERE, "Go to where it was"),
        ("go", {"x": 0.12, "y": -0.46}, {}, "Go: x 12 cm, y -46 cm"),
        ("go", {"x": 0.12, "y": 0.46}, {"x": 0.0}, "Go: x 12 cm, y 46 cm"),
        ("jog", {"dx": 0.0, "dy": -0.5}, HERE, "Jog: down"),
        ("jog", {"dx": 1, "dy": 0.5}, HERE, "Jog: right, up"),
        ("turn", {"angle": -1.5708}, HERE, "Turn: 90° to the right"),
        ("beep", {"seconds": 0.4}, HERE, "Beep for 0.4 s"),
        ("beep", {}, HERE, "Beep"),
        ("say", {"text": "  hello  \n\nworld\nagain"}, HERE, "Say: “hello” and 2 more lines"),
        ("say", {"text": "y" * 90}, HERE, f"Say: “{'y' * 60}…”"),
        ("far", {"wall": 2.5}, HERE, "Go to a place: 2.5 m from the left wall"),
        ("turns", {"times_over": 3.0}, HERE, "Turn around: times over 3"),
        ("gone_away", {"x": 1.0}, HERE, "Gone away"),
    ],
)
def test_what_a_command_does(kind, args, before, words):
    assert command_words(CART, kind, args, before) == words


def test_a_place_that_is_told_from_a_fixed_one_says_so_whatever_was_before():
    told = command_words(spec_of("irat"), "goal", {"map": 1, "x": -0.005, "y": 2.0}, {"x": 1.0, "y": 1.0, "heading": 0})
    assert "0.5 cm left of where its map began, 2 m up from where its map began" in told
    assert way_words(spec_of("irat"), HERE, {"x": 9.0, "y": 9.0, "heading": 0.0}) == "", "its map is not its odometry"


POSE = {"x": 0.5, "y": -0.16, "z": 0.12, "roll": 3.14159}


@pytest.mark.parametrize(
    ("robot", "kind", "args", "words"),
    [
        ("pa10", "joints", {"S1": 0.2967, "S2": -0.5, "speed": 0.3}, "Move joints: shoulder turn 17°, shoulder -29°, 30 % of full speed"),
        ("puma", "joints", {"J1": 0.2967, "J6": 1.0}, "Move joints: waist turn 17°, tool turn 57°"),
        ("puma", "jog_joints", {"J3": -1}, "Turn a joint while held: elbow -1"),
        ("pa10", "gripper", {"closed": 1.0}, "Gripper: 100 % closed"),
        ("pa10", "pick", {"x": 0.5, "y": 0.16}, "Pick up here: 50 cm ahead of the base, 16 cm to its left"),
        ("puma", "put", {"x": -0.5, "y": 0.0}, "Put down here: 50 cm behind the base"),
        ("puma", "pose", POSE, "Move tool: 50 cm ahead of the base, 16 cm to its right, 12 cm above its foot, roll 180°"),
        ("so101", "move", {"elbow_flex": 0.5}, "Move: elbow flex 29°"),
    ],
)  # fmt: skip
def test_an_arm_tells_its_joints_by_plain_words_and_places_from_its_base(robot, kind, args, words):
    assert command_words(spec_of(robot), kind, args, dict.fromkeys(IN_SPACE.coordinates, 0.1)) == words


def test_a_plain_word_is_a_small_one_in_a_sentence_unless_it_is_an_abbreviation():
    spec = replace(CART, words={"times_over": "Turns", "seconds": "TCP time"})
    assert command_words(spec, "turns", {"times_over": 2.0}) == "Turn around: turns 2"
    seconds = Argument("seconds", "s", 0.0, 9.0)
    assert called(spec, seconds) == "TCP time"
    assert called(spec, replace(seconds, label="time")) == "time"


def test_how_far_it_came():
    assert way_words(CART, HERE, {"x": 0.1, "y": 0.4, "heading": 1.0}) == "10 cm right, 2 cm down"
    assert way_words(CART, HERE, HERE) == ""
    assert way_words(CART, {}, HERE) == way_words(CART, HERE, None) == ""
    assert place_words(CART, {"x": 0.1, "y": -2.0}) == "x 10 cm, y -2 m"


@pytest.mark.parametrize("pose", [None, [], [1.0], [1.0, 2.0, nan], [1.0, 2.0, inf], ["1", 2, 3], [True, 1.0, 2.0]])
def test_a_pose_that_is_not_one_of_the_robot_is_no_place(pose):
    assert place_of(CART, pose) == {}


ROBOTS = ("mercury", "pa10", "puma", "irat", "srv1", "so101")
KINDS = [(name, kind.kind) for name in ROBOTS for kind in spec_of(name).commands]
JUNK = st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=300)


@pytest.mark.parametrize(("driver", "kind"), KINDS)
@given(data=st.data())
def test_whatever_a_row_holds_is_told_in_one_short_line(driver, kind, data):
    spec = spec_of(driver)
    found = spec.command(kind)
    args = {a.name: data.draw(JUNK) for a in found.arguments if data.draw(st.booleans())}
    before = {c: data.draw(st.floats(-9, 9)) for c in (spec.pose.coordinates if spec.pose else ())}
    words = command_words(spec, kind, args, before)
    assert words
    assert words == words.strip()
    assert not set("\r\n\0{}[]") & set(words) or any(isinstance(value, str) for value in args.values())
    assert "\n" not in words
    assert len(words) < 120 + 90 * len(args) + 20


@pytest.mark.parametrize(("driver", "kind"), KINDS)
def test_words_of_a_command_name_its_arguments_alone(driver, kind):
    found = spec_of(driver).command(kind)
    assert set(NAMED.findall(found.says)) <= {a.name for a in found.arguments}


@given(st.floats(-1e6, 1e6), st.sampled_from(["m", "rad", "s", "", "m/s"]))
def test_a_quantity_has_no_exponent_and_its_unit(value, unit):
    words = quantity(value, unit)
    assert "e" not in words.split()[0]
    assert {"m": "m", "rad": "°", "": words[-1]}.get(unit, unit) in words
