"""Whole tasks on the model of the objects, planned for the museum arm: what is done, and what is refused by its line."""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.commands import motion_planner
from robots.kit.arms.described import posture
from robots.kit.arms.objects import object_table, objects_of, pose_of, yaw_of
from robots.kit.arms.solids import overlap
from robots.kit.arms.tasks.acts import StepImpossible
from robots.kit.arms.tasks.parsing import parse
from robots.kit.arms.tasks.planning import plan
from robots.kit.arms.tasks.requests import arrangement_of, check_job, foresee_task
from robots.kit.contract.errors import OutOfWorkspace
from robots.kit.contract.objects import KnownObjects, Placed
from robots.kit.description import load

TABLE = objects_of("pa10")
FIRST = Arrangement(TABLE, TABLE.first())
READY = posture(load("pa10"), "ready")
NAMES = ("red", "yellow", "blue", "green")


def planner():
    return motion_planner("pa10", 300.0, {})


def acts(text, arrangement=FIRST):
    return plan(planner(), parse(text), arrangement, READY)


def places(found):
    return {name: tuple(round(v, 4) for v in at.place) for name, at in found[-1].arrangement.places.items()}


def test_a_block_is_taken_from_above_and_put_so_too():
    found = acts("put red on yellow")
    assert [act.kind for act in found] == [
        "gripper",
        "pose",
        "line",
        "gripper",
        "line",
        "pose",
        "line",
        "gripper",
        "line",
    ]
    assert [act.args["closed"] for act in found if act.kind == "gripper"] == [0.0, 1.0, 0.0]
    assert [round(act.args["z"], 4) for act in found if "z" in act.args] == [0.122, 0.022, 0.122, 0.162, 0.063, 0.162]
    assert places(found)["red"] == (0.56, 0.05, 0.06)
    assert [act.arrangement.held for act in found] == [None, None, None, "red", "red", "red", "red", None, None]


def test_each_act_begins_where_the_one_before_has_ended():
    """The plans are those of the motions that the runner asks for, one after another."""
    here = READY
    for act in acts("put red on yellow\nmove 450 0 250\nmove ready\nput blue on red\nput green at 400 -200 45"):
        if act.path is not None:
            begin, *_ = act.path.sample(np.array([0.0]))
            assert begin == pytest.approx(here, abs=1e-5), act.kind
            here = act.path.sample(np.array([act.path.seconds]))[0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("grasp red\ngrasp blue", "Line 2, grasp blue: the gripper holds red already."),
        ("put red on yellow\n\ngrasp yellow", "Line 3, grasp yellow: red lies on yellow."),
        ("put red at 500 -80", "Line 1, put red at 500 -80: blue is there."),
        ("put red on yellow\nput blue on yellow", "Line 2, put blue on yellow: red is there."),
        ("grasp red\nput blue on yellow", "Line 2, put blue on yellow: the gripper holds red, not blue."),
        ("put red on red", "red cannot lie on itself."),
        ("put red on yellow by 30 0", "red would tip: its middle is over nothing."),
        ("put red at 900 0", "900 0 is not on the free part of the table, 320 -420 to 720 420 mm."),
        ("grasp red\nmove 450 0 250\nopen", "Line 3, open: red would fall."),
        ("move 3000 0 0", "Line 1, move 3000 0 0: that is 3 m from the base: the arm reaches"),
        ("move 500 0 -50", "the tool would enter the table."),
        ("move away", "there is no posture away; there are home, ready."),
        ("expect red on yellow", "red lies on table."),
        ("expect holding red", "the gripper holds nothing."),
        ("grasp red\nexpect empty", "Line 2, expect empty: the gripper holds red."),
        ("put red on table", "say where on the table: put A at X Y."),
        ("grasp pink", "there is no object pink; there are red, yellow, blue, green."),
        ("repeat 11\nwait 28\nend", "Line 2, wait 28: the task would take longer than the 300 s that one may take."),
    ],
)
def test_what_cannot_be_done_is_refused_by_its_line_and_cause(text, says):
    with pytest.raises(StepImpossible) as error:
        acts(text)
    assert says in str(error.value)


def test_an_object_that_is_not_known_is_not_touched():
    with pytest.raises(StepImpossible, match="where red lies is not known"):
        acts("grasp red", FIRST.without("red"))


def test_a_tower_in_the_way_is_gone_around():
    """A way by joints that would touch it is not taken: the load goes over it."""
    tower = acts("put blue on yellow\nput green on blue")[-1].arrangement
    beside = tower.with_place("red", pose_of(Placed((0.50, 0.16, 0.02))))
    found = acts("put red at 600 -60", beside)
    for act in found:
        if act.path is None or act.arrangement.held != "red":
            continue
        q = act.path.sample(np.linspace(0, act.path.seconds, 200))
        for tool in planner().planner.chain.forward(q):
            load = TABLE.objects["red"].solid(tool @ pose_of(act.arrangement.places["red"]))
            assert not any(overlap(load, solid, 0.0) for name, solid in act.arrangement.lying("red"))


def test_a_box_of_staff_is_kept_free_by_tasks_too():
    vase = {"name": "the vase", "low": [0.4, 0.1, 0.0], "high": [0.6, 0.3, 0.3]}
    with pytest.raises(StepImpossible, match="the vase"):
        plan(motion_planner("pa10", 300.0, {"boxes": [vase]}), parse("grasp red"), FIRST, READY)


def test_repeated_steps_cost_little_and_a_task_of_too_much_work_is_refused():
    found = acts("repeat 12\nput red on yellow\nput red at 500 160\nend")
    assert [act.args["closed"] for act in found if act.kind == "gripper"] == [0.0, 1.0, 0.0] * 24
    assert [act.step for act in found] == sorted(act.step for act in found)
    ways = "\n".join(f"put red at {400 + 7 * (n % 20)} {200 + 10 * (n % 7)}\nmove home" for n in range(60))
    with pytest.raises(StepImpossible, match="more than may be planned at once"):
        acts(ways)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(NAMES), st.sampled_from(NAMES)), min_size=1, max_size=5))
def test_whatever_is_stacked_nothing_is_in_anything_and_everything_rests(pairs):
    arrangement = FIRST
    for upper, lower in pairs:
        try:
            arrangement = acts(f"put {upper} on {lower}", arrangement)[-1].arrangement
        except StepImpossible:
            continue
        solids = list(arrangement.lying())
        assert len(solids) == len(NAMES)
        assert not any(overlap(a, b) for n, (_, a) in enumerate(solids) for _, b in solids[:n])
        assert all(arrangement.beneath(name) for name in NAMES)
        assert lower in arrangement.beneath(upper)


def test_a_preview_shows_the_way_up_to_a_line_that_cannot_be_done():
    text = {"text": "put red on yellow\ngrasp yellow"}
    found = foresee_task(planner(), TABLE, "task", text, tuple(READY), ())
    assert found.judgements[0].text == "Line 2, grasp yellow: red lies on yellow."
    assert found.judgements[0].at_s == pytest.approx(found.seconds, abs=1e-6)
    assert set(found.steps) == {0, 1}
    assert len(found.path) == len(found.tool) == len(found.steps)
    whole = foresee_task(planner(), TABLE, "task", {"text": "put red on yellow"}, tuple(READY), ())
    assert (whole.judgements, whole.path) == ((), found.path)


def test_a_job_is_judged_by_the_packets_of_the_objects():
    known = KnownObjects(TABLE.box)
    numbers = {TABLE.objects[name].number: at for name, at in FIRST.places.items()}
    packets = [(known.key(numbers), True)]
    check_job(planner(), TABLE, {"text": "grasp yellow"}, packets)
    packets.append((known.delta({**numbers, 0: Placed((0.56, 0.05, 0.06))}), False))
    assert arrangement_of(TABLE, packets).beneath("red") == ("yellow",)
    with pytest.raises(OutOfWorkspace, match="red lies on yellow"):
        check_job(planner(), TABLE, {"text": "grasp yellow"}, packets)
    assert arrangement_of(TABLE, [(b"torn", True)]).places == FIRST.places


def bricks(carries=("A", "B"), **rod):
    """Return other objects on the same table: two long bricks that are pressed on, and a rod that hangs beside them."""
    made = copy.deepcopy(load("pa10"))
    made["objects"]["release"] = -0.0005
    above = {"tool": [0.0, 0.0, 0.013], "rpy_deg": [180.0, 0.0, 90.0], "away": [0.0, 0.0, 0.08]}
    brick = {
        "shape": "box",
        "size": [0.0318, 0.0636, 0.0192],
        "colour": [1, 0, 0],
        "turns": 2,
        "carries": list(carries),
    }
    beside = {"tool": [0.0, 0.0, 0.0], "rpy_deg": [0.0, 90.0, 0.0], "away": [-0.09, 0.0, 0.0]}
    hanging = {"name": "rod", "shape": "cylinder", "size": [0.012, 0.012, 0.24], "colour": [0, 0, 0], "hangs": True}
    made["object"] = [
        brick | {"name": "A", "place": [0.45, 0.2, 0.0096], "grasp": [above]},
        brick | {"name": "B", "place": [0.55, -0.1, 0.0096], "rpy_deg": [0, 0, 30], "grasp": [above]},
        hanging | {"place": [0.75, 0.0, 0.35], "grasp": [beside], **rod},
    ]
    table = object_table(made)
    return Arrangement(table, table.first())


def test_a_long_brick_is_put_with_its_studs_in_line_and_pressed_on():
    found = acts("put A on B", bricks())
    pose = pose_of(found[-1].arrangement.places["A"])
    assert np.degrees(yaw_of(pose)) % 180 == pytest.approx(30.0, abs=1e-6)
    assert pose[:3, 3] == pytest.approx([0.55, -0.1, 0.0288], abs=1e-9)
    down = [act.args["z"] for act in found if act.kind == "line"][-2]
    assert down == pytest.approx(0.0288 + 0.013 - 0.0005, abs=1e-9)
    across = pose_of(acts("put A on B by 15.9 0 turned 90", bricks())[-1].arrangement.places["A"])
    assert np.degrees(yaw_of(across)) % 180 == pytest.approx(120.0, abs=1e-6)
    turned = np.radians(30.0)
    assert across[:2, 3] == pytest.approx([0.55 + 0.0159 * np.cos(turned), -0.1 + 0.0159 * np.sin(turned)], abs=1e-9)


def test_a_rod_that_hangs_is_taken_from_the_side():
    found = acts("grasp rod\nexpect holding rod", bricks())
    places = [[act.args[axis] for axis in "xyz"] for act in found if act.kind in ("pose", "line")]
    assert places[0] == pytest.approx([0.66, 0.0, 0.35], abs=1e-9)
    assert places[1] == pytest.approx([0.75, 0.0, 0.35], abs=1e-9)
    assert places[2] == pytest.approx([0.75, 0.0, 0.45], abs=1e-9)
    assert found[-1].arrangement.held == "rod"


def test_nothing_is_put_where_the_rod_hangs_nor_on_what_may_not_carry_it():
    with pytest.raises(StepImpossible, match="rod is there"):
        acts("put A at 650 0", bricks(place=[0.65, 0.0, 0.12]))
    with pytest.raises(StepImpossible, match="A may not be put on B"):
        acts("put A on B", bricks(carries=("B",)))
