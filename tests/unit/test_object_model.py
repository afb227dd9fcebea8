"""Objects of a description, and the belief about where they are: kept in a file that may be torn or hostile."""

import copy
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.arms.beliefs import BROKEN, LARGEST, How, ObjectModel
from robots.kit.arms.hand import Hand
from robots.kit.arms.object_streams import BELIEFS, OBJECTS, ObjectStreams
from robots.kit.arms.objects import BadDescription, object_table, objects_of
from robots.kit.contract.objects import KnownObjects, Placed
from robots.kit.contract.session import RobotState
from robots.kit.description import load

TABLE = objects_of("pa10")
ELSEWHERE = Placed((0.4, 0.3, 0.02))


def changed(*path, to):
    """Return the description of the museum arm with one value changed."""
    made = copy.deepcopy(load("pa10"))
    *inner, last = path
    at = made
    for key in inner:
        at = at[key]
    at[last] = to
    return made


@pytest.mark.parametrize(
    ("path", "to", "says"),
    [
        (("object", 0, "name"), "Red!", "object 1 needs a name of letters"),
        (("object", 0, "name"), "table", "no word of tasks"),
        (("object", 1, "name"), "red", "two objects have the same name"),
        (("object", 0, "shape"), "ball", "object red: shape is box or cylinder"),
        (("object", 0, "size"), [0.04, 0.04], "object red: size needs 3 numbers"),
        (("object", 0, "size"), [0.04, 0.04, 0.0], "object red: size is three edges up to 2 m"),
        (("object", 0, "size"), [0.04, float("nan"), 0.04], "object red: size needs finite numbers"),
        (("object", 0, "place"), [0.5, 9.0, 0.02], "object red: its first place is outside the box of objects"),
        (("object", 0, "turns"), 0, "object red: turns is a whole number"),
        (("object", 0, "carries"), ["pink"], "object red: carries names 'pink'"),
        (("object", 0, "grasp"), [], "object red: it needs at least one"),
        (("object", 0, "grasp", 0, "away"), [0, 0, 0], "object red: away is the way"),
        (("object", 0, "grasp", 0, "tool"), [0, 0, 0.5], "object red: a grasp holds it within 0.256 m of the tool"),
        (("objects", "size"), [2.0, 0.0, 1.0], "objects: a box needs finite numbers and a size above zero"),
        (("objects", "area"), [[0.7, 0.4], [0.3, -0.4]], "objects: the first corner of area lies below the second"),
        (("objects", "hand"), [[[0, 0, 0]]], "objects: each box of hand has two corners"),
        (("objects", "hand"), [[[0, 0, 0], [1, 0, 1]]], "objects: each box of hand has two corners"),
        (("objects", "hand"), [[[0, 0], [1, 1]]], "objects: hand needs 3 numbers"),
        (("object", 0, "hangs_from"), 0.0, "object red: hangs_from is above its first place"),
        (("objects",), 3, "the table [objects] is needed"),
    ],
)
def test_a_description_that_cannot_be_is_refused_with_the_object(path, to, says):
    with pytest.raises(BadDescription) as error:
        object_table(changed(*path, to=to))
    assert says in str(error.value)


def model(file=None, heard=None):
    return ObjectModel(TABLE, file, lambda: 1000, (heard if heard is not None else []).append)


def test_what_is_believed_says_how_and_when_and_is_kept(tmp_path):
    file = tmp_path / "folder" / "objects.json"
    one = model(file)
    assert one.belief("red").how == How.START
    one.place("red", ELSEWHERE, How.STAFF)
    one.place("blue", None, How.DROPPED)
    again = model(file)
    assert again.belief("red") == one.belief("red")
    assert (again.belief("red").placed, again.belief("red").how, again.belief("red").at_ms) == (
        ELSEWHERE,
        How.STAFF,
        1000,
    )
    assert set(again.arrangement.places) == {"red", "yellow", "green"}


GOOD = {"how": "set by staff", "at_ms": 5, "place": [0.4, 0.3, 0.02], "rotation": [0, 0, 0, 1], "held": False}


@pytest.mark.parametrize(
    "content",
    [
        b"", b"{", b"\xff\xfe", b"[]", b'{"red": 3}', b"[" * LARGEST,
        json.dumps({"red": GOOD | {"how": "by magic"}}).encode(),
        json.dumps({"red": GOOD | {"place": [9.0, 0.0, 0.0]}}).encode(),
        json.dumps({"red": GOOD | {"place": [0.4, 0.3]}}).encode(),
        json.dumps({"red": GOOD | {"rotation": [0, 0, 0, 0]}}).encode(),
        json.dumps({"red": GOOD | {"more": 1}}).encode(),
        json.dumps({"red": GOOD | {"held": True}, "blue": GOOD | {"held": True}}).encode(),
        b'{"red": {"how": "set by staff", "at_ms": 5, "place": [1e999, 0, 0]}}',
    ],
)  # fmt: skip
def test_a_torn_or_hostile_file_gives_the_first_places_and_says_so(tmp_path, content):
    file, heard = tmp_path / "objects.json", []
    file.write_bytes(content)
    one = model(file, heard)
    assert one.arrangement.places == TABLE.first()
    one.repeat()
    assert heard[-1].note == BROKEN
    one.place("red", ELSEWHERE, How.STAFF)
    assert heard[-1].note == ""
    assert model(file).belief("red").placed == ELSEWHERE


@given(st.binary(max_size=200))
def test_any_file_is_read_or_refused(tmp_path_factory, content):
    file = tmp_path_factory.mktemp("any") / "objects.json"
    file.write_bytes(content)
    assert set(model(file).arrangement.places) <= set(TABLE.objects)


def test_a_file_of_other_objects_leaves_ours_where_they_are_first(tmp_path):
    file = tmp_path / "objects.json"
    file.write_text(json.dumps({"pink": GOOD, "red": GOOD}))
    one = model(file)
    assert one.belief("red").placed == ELSEWHERE
    assert one.belief("blue").how == How.START


def test_nothing_is_sent_of_an_object_that_is_carried():
    sent, wants = [], [False]

    def send(name, data, key):
        sent.append((name, data, key))
        return wants[0]

    streams = ObjectStreams(TABLE, send)
    one = ObjectModel(TABLE, None, lambda: 7, streams.tell)
    reader = KnownObjects(TABLE.box)

    def read():
        for _, data, key in [packet for packet in sent if packet[0] == OBJECTS]:
            reader.take(data, key)
        found, sent[:] = [len(data) for name, data, _ in sent if name == OBJECTS], []
        return found

    one.repeat()
    assert json.loads(next(data for name, data, _ in sent if name == BELIEFS))["objects"]["red"]["how"] == How.START
    assert read() == [4 * 12]
    grip = Placed((0.0, 0.0, 0.002), (1.0, 0.0, 0.0, 0.0), held=True)
    one.place("red", grip, How.ARM)
    assert read() == [12]
    assert reader.objects[0].held
    one.take(one.arrangement, How.ARM)
    assert read() == []
    one.place("red", ELSEWHERE, How.ARM)
    assert read() == [12]
    assert reader.objects[0].place == pytest.approx(ELSEWHERE.place, abs=1e-4)
    wants[0] = True
    one.place("red", None, How.MISSED)
    one.place("blue", None, How.MISSED)
    assert read() == [12, 2 * 12], "the second is a key packet, because the first was not taken"


@pytest.mark.parametrize(
    ("opening", "holds"), [(0.0, False), (0.002, False), (0.018, True), (0.037, True), (0.039, False), (0.04, False)]
)
def test_a_gripper_that_tells_its_opening_knows_whether_it_holds(opening, holds):
    hand = Hand(load("pa10"), ("a", "gripper"))
    assert hand.holds(RobotState(0.0, (0.0, opening), (), False, True)) is holds
    assert hand.holds(None) is None


def test_a_gripper_that_tells_nothing_knows_nothing():
    hand = Hand({"gripper": {"open": 0.04}}, ("a", "gripper"))
    assert not hand.tells
    assert hand.holds(RobotState(0.0, (0.0, 0.0), (), False, True)) is None
