"""What can be won with an arm's objects: read from the description, planned on the plate, judged from the beliefs."""

import copy
from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.beliefs import Belief, How, Snapshot
from robots.kit.arms.commands import motion_planner
from robots.kit.arms.described import posture
from robots.kit.arms.goals import goal_facts, goals_in, goals_of, missing
from robots.kit.arms.judging import SWUNG_MS, GoalJudge
from robots.kit.arms.objects import object_table, objects_of, placed_of, pose_of, yaw_of
from robots.kit.arms.tables import BadDescription
from robots.kit.arms.tasks.acts import StepImpossible
from robots.kit.arms.tasks.parsing import parse
from robots.kit.arms.tasks.planning import plan
from robots.kit.arms.tasks.requests import check_request
from robots.kit.contract.errors import BadRequest
from robots.kit.description import load, programs_of

TABLE = objects_of("puma")
FIGURE, ROD, SWING = goals_of("puma")
FIRST = Arrangement(TABLE, TABLE.first())
READY = posture(load("puma"), "ready")
DOWN = Rotation.from_euler("x", 180, degrees=True).as_matrix()


def changed(change):
    made = copy.deepcopy(load("puma"))
    change(made)
    return made


def part(n, **values):
    """Return a change of a part of the figure; a value of None removes it."""

    def change(made):
        one = made["goal"][0]["part"][n]
        one.update(values)
        for name in [name for name, value in values.items() if value is None]:
            del one[name]

    return change


def goal(n, **values):
    return lambda made: made["goal"][n].update(values)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (goal(0, name="f!"), "goal 1 needs a name of letters, digits and hyphens"),
        (goal(1, name="figure"), "two goals have the same name"),
        (goal(0, title=""), "goal figure: title is what people read"),
        (goal(0, kind="win"), "goal figure: kind is build, lift or catch"),
        (goal(0, within_m=0.0), "goal figure: within_m is above 0"),
        (goal(0, within_deg="5"), "goal figure: within_deg needs finite numbers"),
        (goal(0, part=[]), "goal figure: a figure needs at least one [[goal.part]]"),
        (goal(1, object="pole"), "goal rod: object names none of a, b, c, d, e, rod"),
        (goal(2, far_m=-1), "goal swing: far_m is above 0"),
        (part(0, object="z"), "goal figure: a part's object names none of a, b, c, d, e, rod"),
        (part(1, object="a"), "goal figure: a is a part twice"),
        (part(2, on="e"), "goal figure, part c: on is table, plate, or the object of a part before it"),
        (part(0, stud=[0, 1]), "goal figure, part a: stud is a column and a row of the plate"),
        (part(2, stud=[1, 1]), "goal figure, part c: stud is a column and a row of the plate"),
        (part(0, stud=[9, 1]), "goal figure, part a: there is no room at 9 1: the plate has 10 columns, 10 rows"),
        (part(0, turned_deg=45), "goal figure, part a: onto studs it is turned by 0, 90, 180 or 270 degrees"),
        (part(1, stud=[3, 5]), "goal figure, part b: a is there"),
        (part(4, by_m=[0.05, 0.0]), "goal figure, part e: e would tip: its middle is over nothing"),
        (part(0, on="table"), "goal figure, part a: at_m needs 2 numbers"),
        (part(0, on="table", at_m=[0.42, -0.36], stud=None), "goal figure, part a: plate is there"),
        (lambda made: made.update(goal={}), None),
        (lambda made: made.update(goal="no"), "at most 16 tables [[goal]] are possible"),
    ],
)
def test_a_goal_that_cannot_be_is_refused_with_its_name_and_the_cause(change, says):
    made = changed(change)
    if says is None:
        with pytest.raises(BadDescription):
            goals_in(made, object_table(made))
        return
    with pytest.raises(BadDescription) as error:
        goals_in(made, object_table(made))
    assert says in str(error.value)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda made: made["plate"].update(studs=[0, 3]), "plate: studs is two whole numbers from 1 to 99"),
        (lambda made: made["plate"].update(pitch_m=0), "plate: pitch_m and thick_m are above zero"),
        (lambda made: made["plate"].update(thick_m=None), "plate: thick_m needs finite numbers"),
        (lambda made: made["plate"].update(place=[0, 0]), "plate: place needs 3 numbers"),
        (lambda made: made.update(plate=3), "the table [plate] is needed"),
        (lambda made: made["object"][0].update(name="plate"), "object 1 needs a name"),
    ],
)
def test_a_plate_that_cannot_be_is_refused(change, says):
    with pytest.raises(BadDescription) as error:
        object_table(changed(change))
    assert says in str(error.value)


def test_an_arm_without_goals_tells_none_and_has_no_plate():
    assert goal_facts("pa10") == {}
    assert objects_of("pa10").plate is None
    with pytest.raises(BadRequest, match=r"Line 1: there is no object plate"):
        check_request(objects_of("pa10"), "task", {"text": "put red on plate"})


def test_any_arm_with_objects_may_declare_a_figure_that_stands_on_its_table():
    parts = [
        {"object": "yellow", "on": "table", "at_m": [0.5, 0.2], "turned_deg": 30.0},
        {"object": "red", "on": "yellow", "by_m": [0.01, 0.0]},
    ]
    made = copy.deepcopy(load("pa10")) | {"goal": [{"name": "two", "title": "Two", "kind": "build", "part": parts}]}
    (two,) = goals_in(made, objects_of("pa10"))
    assert two.parts["yellow"][:3, 3] == pytest.approx([0.5, 0.2, 0.02])
    there = np.array([0.5, 0.2, 0.06]) + 0.01 * np.array([np.cos(radians(30)), np.sin(radians(30)), 0.0])
    assert two.parts["red"][:3, 3] == pytest.approx(there)
    assert yaw_of(two.parts["red"]) == pytest.approx(radians(30))


def planned(text, arrangement=FIRST):
    check_request(TABLE, "task", {"text": text})
    return plan(motion_planner("puma", 300.0, {}), parse(text), arrangement, READY)[-1].arrangement


def test_the_task_of_the_gallery_builds_the_figure_by_the_model():
    after = planned(dict(programs_of("puma", "task"))["The figure of five bricks"])
    for name, pose in FIGURE.parts.items():
        metres, angle = missing(TABLE.objects[name], after.pose(name), pose)
        assert metres < 1e-6 and angle < 1e-6, name


@given(st.integers(1, 10), st.integers(1, 10), st.sampled_from((0, 90, 180, 270)))
def test_a_brick_covers_the_stud_that_is_named_with_its_corner_or_has_no_room(column, row, turned):
    on_plate, wide = TABLE.plate, (4, 2) if turned % 180 == 0 else (2, 4)
    rotation = Rotation.from_euler("z", turned, degrees=True).as_matrix()
    if column + wide[0] > 11 or row + wide[1] > 11:
        with pytest.raises(ValueError, match=f"no room at {column} {row}"):
            FIRST.on_top("a", rotation, "plate", (0.0, 0.0), (column, row))
        return
    pose = FIRST.on_top("a", rotation, "plate", (0.0, 0.0), (column, row))
    covered = (TABLE.objects["a"].solid(pose).corners[:, :2] - on_plate.place[:2]) / on_plate.pitch + 5
    assert covered.min(axis=0) == pytest.approx([column - 1, row - 1])
    assert covered.max(axis=0) == pytest.approx([column - 1 + wide[0], row - 1 + wide[1]])
    FIRST.check_place("a", pose)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("put a on plate at 8 1", "Line 1, put a on plate at 8 1: there is no room at 8 1"),
        ("put a on plate at 1 1 turned 45", "onto studs it is turned by 0, 90, 180 or 270 degrees."),
        ("put a on plate at 3 3\nput b on plate at 4 4", "Line 2, put b on plate at 4 4: a is there."),
        ("put a on plate by 90 0", "a would tip: its middle is over nothing."),
        ("put a at 420 -360", "Line 1, put a at 420 -360: plate is there."),
        ("grasp plate", "there is no object plate"),
        ("put plate on a", "there is no object plate"),
        ("put a on plate\nexpect a on table", "Line 2, expect a on table: a lies on plate."),
        ("expect a on plate", "Line 1, expect a on plate: a lies on table."),
    ],
)
def test_what_the_plate_does_not_allow_is_refused_by_its_line(text, says):
    with pytest.raises((StepImpossible, BadRequest)) as error:
        planned(text)
    assert says in str(error.value)


def test_a_brick_is_put_on_the_plate_beside_its_middle_and_taken_off_again():
    after = planned("put a on plate by 15.9 0\nexpect a on plate\nput a at 420 -200\nexpect a on table")
    assert after.pose("a")[:3, 3] == pytest.approx([0.42, -0.2, 0.0096])


class Cell:
    """A judge with beliefs that a test sets."""

    def __init__(self):
        self.now_ms = 1000
        self.judge = GoalJudge(TABLE, goals_of("puma"), lambda: self.now_ms)
        self.beliefs = {name: Belief(How.START, 0, one.place, one.rotation) for name, one in TABLE.first().items()}

    def look(self, tool=None):
        self.judge.look(Snapshot(self.beliefs), tool)
        return [one.name for one in self.judge.news()]

    def put(self, name, pose, how=How.ARM, held=False):
        placed = placed_of(pose, held)
        self.beliefs[name] = Belief(how, self.now_ms, placed.place, placed.rotation, held)

    def there(self, goal="figure"):
        return self.judge.facts()[goal]["there"]


def moved(pose, mm=0.0, deg=0.0):
    made = pose.copy()
    made[0, 3] += mm / 1000
    made[:3, :3] = Rotation.from_euler("z", deg, degrees=True).as_matrix() @ made[:3, :3]
    return made


@given(st.permutations("abcde"))
def test_the_figure_is_won_once_whatever_the_order_and_again_after_it_was_taken_apart(order):
    cell = Cell()
    assert cell.look() == []
    for count, name in enumerate(order, 1):
        cell.put(name, FIGURE.parts[name])
        assert cell.look() == (["figure"] if count == 5 else [])
        assert sorted(cell.there()) == sorted(order[:count])
    assert cell.judge.facts()["figure"]["won_ms"] == 1000
    assert cell.look() == []
    cell.put(order[0], moved(FIGURE.parts[order[0]], mm=20))
    assert cell.look() == []
    assert order[0] not in cell.there()
    cell.put(order[0], FIGURE.parts[order[0]])
    cell.now_ms = 9000
    assert cell.look() == ["figure"]
    assert cell.judge.facts()["figure"]["won_ms"] == 9000


@given(st.floats(-6, 6), st.floats(-10, 10), st.sampled_from((0, 180)))
def test_a_brick_is_there_within_the_tolerances_and_half_a_turn_is_none(mm, deg, turn):
    cell = Cell()
    cell.put("c", moved(FIGURE.parts["c"], mm, deg + turn))
    cell.look()
    if abs(abs(mm) - 3) > 1e-6 and abs(abs(deg) - 5) > 1e-6:
        assert ("c" in cell.there()) == (abs(mm) < 3 and abs(deg) < 5)
    metres, angle = missing(TABLE.objects["c"], moved(FIGURE.parts["c"], mm, deg + turn), FIGURE.parts["c"])
    assert metres == pytest.approx(abs(mm) / 1000, abs=1e-9)
    assert angle == pytest.approx(abs(radians(deg)), abs=1e-6)


def test_what_stands_already_when_the_driver_begins_is_there_and_not_won():
    cell = Cell()
    for name, pose in FIGURE.parts.items():
        cell.put(name, pose)
    assert cell.look() == []
    assert cell.judge.facts()["figure"] == {"there": tuple("abcde"), "won_ms": None}


def test_a_brick_in_the_gripper_or_lost_is_not_there():
    cell = Cell()
    cell.put("a", FIGURE.parts["a"], held=True)
    cell.beliefs["b"] = Belief(How.MISSED, 0)
    cell.look()
    assert cell.there() == ()


def tool(z):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = DOWN, (0.55, 0.3, z)
    return pose


def test_the_rod_is_won_when_it_is_held_and_lifted():
    cell, grip = Cell(), np.linalg.inv(tool(0.3)) @ pose_of(TABLE.first()["rod"])
    cell.look()
    assert cell.judge.lifts("rod") and not cell.judge.lifts("a") and not cell.judge.lifts(None)
    cell.put("rod", grip, held=True)
    assert cell.look() == [], "where the tool is is not known"
    assert cell.look(tool(0.329)) == []
    assert cell.look(tool(0.331)) == ["rod"]
    assert cell.look(tool(0.35)) == []


@pytest.mark.parametrize(
    ("places_mm", "late_ms", "how", "won"),
    [
        ((40,), 100, How.MEASURED, ["swing"]),  # that far from where it hangs
        ((20, -20), 100, How.MEASURED, ["swing"]),
        ((10, -10, 15), 100, How.MEASURED, []),  # it hangs almost still
        ((40,), SWUNG_MS + 100, How.MEASURED, []),  # that was before it came to rest
        ((40, -40), 100, How.STAFF, []),  # nobody has seen it swing
        ((), 100, How.MEASURED, []),
    ],
)
def test_the_rod_is_caught_if_it_was_seen_to_swing_right_before(places_mm, late_ms, how, won):
    cell, hangs = Cell(), pose_of(TABLE.first()["rod"])
    cell.look()
    for mm in places_mm:
        cell.now_ms += 200
        cell.put("rod", moved(hangs, mm), how)
        cell.look()
    cell.now_ms += late_ms
    cell.put("rod", np.linalg.inv(tool(0.3)) @ hangs, held=True)
    assert cell.look() == won
    cell.put("rod", hangs)
    assert cell.look() == []


def test_pages_are_told_where_each_part_belongs():
    figure, rod, _ = goal_facts("puma")["goals"]
    assert [one["object"] for one in figure["parts"]] == [*"abcde"]
    assert figure["parts"][2]["pose"][3::4][:3] == pytest.approx([0.42, -0.36, 0.0328])
    assert rod["parts"][0]["pose"][3::4][:3] == pytest.approx([0.55, 0.3, 0.33])
    assert SWING.title == "The rod, caught while it swings" and ROD.far == 0.03
