"""Where a command takes a robot: every command of every robot, whatever its arguments are; no text is told."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.capabilities import Programs
from robots.kit.contract.find import spec_of
from robots.kit.contract.spec import Argument, CommandKind, Spec
from robots.kit.contract.target import LONGEST, target_of
from tests.unit.test_command_words import CART, HERE

ROBOTS = ("mercury", "pa10", "puma", "irat", "srv1", "so101")
NUMBERS = st.floats(-1e6, 1e6) | st.integers(-9, 9) | st.booleans() | st.none() | st.text(max_size=9)
SECRET = "zirconium spoon"


@pytest.mark.parametrize(
    ("kind", "args", "before", "target"),
    [
        ("go", {"x": 0.12, "y": 0.46}, HERE, {"words": "Go to 12 cm right, 4 cm up", "place": {"x": 0.12, "y": 0.46}}),
        ("go", {"x": 0.12, "y": 0.46}, None, {"words": "Go: x 12 cm, y 46 cm", "place": {"x": 0.12, "y": 0.46}}),
        ("turn", {"angle": 1.5708}, HERE, {"words": "Turn: 90° to the left"}),
        ("beep", {"seconds": 2.0}, HERE, {"words": "Beep for 2 s"}),
        ("jog", {"dx": 1.0, "dy": 0.0}, HERE, {}),
        ("calibrate", {}, HERE, {}),
        ("say", {"text": SECRET}, HERE, {"words": "Say"}),
    ],
)
def test_a_target_is_a_sentence_and_a_place_if_the_command_names_one(kind, args, before, target):
    assert target_of(CART, kind, args, before) == target


def test_a_text_that_belongs_to_the_words_is_not_told_and_a_setting_has_no_target():
    text, level = Argument("text", "", 1, 99, text=True), Argument("level", "", 0.0, 9.0)
    spec = Spec(
        "Bell",
        (
            CommandKind("say", "Say", (text,), says="Say {text}"), CommandKind("do", "Run", (text, level)),
            CommandKind("loud", "Loudness", (level,), lane="config", moves=False, asked_by=frozenset({"staff"})),
        ),
        capabilities=(Programs("do", "lines"),),
    )  # fmt: skip
    assert target_of(spec, "say", {"text": SECRET}) == {"words": "Say"}
    assert target_of(spec, "do", {"text": SECRET, "level": 3.0}) == {"words": "Run"}
    assert target_of(spec, "loud", {"level": 3.0}) == {}


@pytest.mark.parametrize("robot", ROBOTS)
@given(data=st.data())
def test_of_no_robot_is_a_text_told_and_a_place_has_the_coordinates_of_its_pose(robot, data):
    spec = spec_of(robot)
    command = data.draw(st.sampled_from(spec.commands))
    args = {a.name: SECRET if a.text else data.draw(NUMBERS) for a in command.arguments}
    names = spec.pose.coordinates if spec.pose else ()
    before = data.draw(st.none() | st.fixed_dictionaries(dict.fromkeys(names, st.floats(-9.0, 9.0))))
    target = target_of(spec, command.kind, args, before)
    assert target.keys() <= {"words", "place"}
    assert SECRET not in str(target)
    assert (target == {}) == (command.held or not command.moves or command.lane != "motion")
    assert len(target.get("words", "")) <= LONGEST
    assert target.get("place", {}).items() <= args.items()
    assert target.get("place", {}).keys() <= set(names)
