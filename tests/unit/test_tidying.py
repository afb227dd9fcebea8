"""In which order objects are brought back to their first places, for towers, taken places and circles of them."""

from math import degrees, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.arms.arrangement import Arrangement, NotPossible
from robots.kit.arms.objects import objects_of, placed_of, pose_of, upright
from robots.kit.arms.tasks.steps import Open, PutAt
from robots.kit.arms.tasks.tidying import displaced, first_pose, moves
from robots.kit.contract.find import spec_of
from robots.kit.contract.procedures import offered_procedures
from robots.kit.contract.spec import STAFF
from robots.kit.contract.tidying import Tidy

NEAR = 0.015, radians(20.0)
BLOCKS, BRICKS = objects_of("pa10"), objects_of("puma")
BOUND = 2  # moves of one object: aside, and to its place
GRID = [(x / 100, y / 100) for x in range(34, 72, 6) for y in range(-40, 42, 8)]


def stood(table, name, x, y, on=None, yaw=0.0, places=None):
    """Return a place of an object on the table, or on another one of `places`."""
    described = table.objects[name]
    height = table.height if on is None else Arrangement(table, places).solid(on).top
    return placed_of(described.standing(upright(pose_of(described.first), yaw), x, y, height))


@st.composite
def lying(draw, table=BLOCKS):
    """Draw where objects lie: at first places of any of them, anywhere on the table, or on each other."""
    places = {}
    names = draw(st.permutations([name for name, one in table.objects.items() if not one.hangs]))
    for name in names:
        kind = draw(st.sampled_from(["first", "other", "table", "on", "on"]))
        yaw = draw(st.sampled_from([0.0, 0.3, 1.0]))
        if kind == "on" and places:
            below = draw(st.sampled_from(sorted(places)))
            while over := [n for n in places if below in Arrangement(table, places).beneath(n)]:
                below = over[0]
            x, y = places[below].place[:2]
            placed = stood(table, name, x, y, below, yaw, places)
        elif kind in ("first", "other"):
            of = name if kind == "first" else draw(st.sampled_from(names))
            placed = (
                placed_of(first_pose(table, of)) if of == name else stood(table, name, *first_pose(table, of)[:2, 3])
            )
        else:
            placed = stood(table, name, *draw(st.sampled_from(GRID)), yaw=yaw)
        try:
            Arrangement(table, places).check_place(name, pose_of(placed))
        except NotPossible:
            placed = table.objects[name].first
            try:
                Arrangement(table, places).check_place(name, pose_of(placed))
            except NotPossible:
                continue  # nobody knows where it is
        places[name] = placed
    return Arrangement(table, places)


def carried_out(arrangement, move):
    """Return the objects after a move, which must be one that may be done."""
    if arrangement.held is None:
        arrangement.check_grasp(move.name)
    described, action = arrangement.described(move.name), move.action
    if isinstance(action, Open):
        return arrangement.with_place(move.name, pose_of(described.first))
    x, y = (v / 1000 for v in action.at)
    yaw = radians(action.yaw or 0.0)
    pose = described.standing(upright(pose_of(described.first), yaw), x, y, arrangement.table.height)
    arrangement.check_place(move.name, pose)
    return arrangement.with_place(move.name, pose)


def tidied(arrangement):
    """Carry out the first move again and again; return the objects at the end, and the moves."""
    done, aside = [], set()
    while (move := next(moves(arrangement, NEAR, aside), None)) is not None:
        arrangement = carried_out(arrangement, move)
        done.append(move)
        aside |= {move.name} if move.aside else set()
        assert len(done) <= BOUND * len(arrangement.table.objects)
    return arrangement, done


@given(lying())
def test_every_block_that_is_known_comes_to_its_place_in_moves_that_may_be_done(arrangement):
    off = displaced(arrangement, NEAR)
    after, done = tidied(arrangement)
    assert displaced(after, NEAR) == ()
    assert {move.name for move in done} == set(off), "what is in its place stays there"
    assert sum(not move.aside for move in done) == len(off), "each is brought back once"
    assert after.places.keys() == arrangement.places.keys()


@given(lying(BRICKS))
def test_bricks_beside_a_plate_come_to_their_places_too(arrangement):
    after, _ = tidied(arrangement)
    assert displaced(after, NEAR) == ()


@given(lying(), st.data())
def test_what_is_held_is_put_down_before_all_else(arrangement, data):
    if not arrangement.places:
        return
    name = data.draw(st.sampled_from(sorted(arrangement.places)))
    try:
        arrangement.check_grasp(name)
    except NotPossible:
        return
    tool = arrangement.pose(name) @ arrangement.described(name).grasps[0].tool
    after, done = tidied(arrangement.with_held(name, tool))
    assert done[0].name == name
    assert displaced(after, NEAR) == ()


def test_the_top_of_a_tower_goes_first():
    x, y = 0.44, 0.30
    places = {"red": stood(BLOCKS, "red", x, y)}
    places["blue"] = stood(BLOCKS, "blue", x, y, "red", 0.0, places)
    _, done = tidied(Arrangement(BLOCKS, places))
    assert [(move.name, move.aside) for move in done] == [("blue", False), ("red", False)]


def test_two_blocks_that_have_changed_places_need_one_put_aside():
    places = dict(BLOCKS.first())
    places["red"], places["blue"] = (
        stood(BLOCKS, one, *first_pose(BLOCKS, other)[:2, 3]) for one, other in (("red", "blue"), ("blue", "red"))
    )
    after, done = tidied(Arrangement(BLOCKS, places))
    assert [(move.name, move.aside) for move in done] == [("red", True), ("blue", False), ("red", False)]
    assert displaced(after, NEAR) == ()


def test_what_was_put_aside_once_is_not_again():
    """So a place that the arm never reaches does not let it go on for ever."""
    places = dict(BLOCKS.first())
    places["red"], places["blue"] = (
        stood(BLOCKS, one, *first_pose(BLOCKS, other)[:2, 3]) for one, other in (("red", "blue"), ("blue", "red"))
    )
    offered = list(moves(Arrangement(BLOCKS, places), NEAR, {"red", "blue"}))
    assert offered == []
    assert {move.name for move in moves(Arrangement(BLOCKS, places), NEAR, {"red"})} == {"blue"}


@pytest.mark.parametrize(("m", "turned", "off"), [(0.010, 10.0, False), (0.020, 0.0, True), (0.0, 30.0, True), (0.0, 95.0, False)])  # fmt: skip
def test_a_block_near_its_place_stays(m, turned, off):
    """A cube looks the same after a quarter turn."""
    x, y = first_pose(BLOCKS, "red")[:2, 3]
    places = dict(BLOCKS.first()) | {"red": stood(BLOCKS, "red", x + m, y, yaw=radians(turned))}
    assert displaced(Arrangement(BLOCKS, places), NEAR) == (("red",) if off else ())


def test_what_hangs_is_let_go_if_it_is_held_and_else_left():
    rod = BRICKS.objects["rod"]
    away = placed_of(pose_of(rod.first) + np.array([[0, 0, 0, 0.1]] * 3 + [[0, 0, 0, 0]]))
    assert displaced(Arrangement(BRICKS, {"rod": away}), NEAR) == ()
    held = Arrangement(BRICKS, {"rod": rod.first}).with_held("rod", pose_of(rod.first) @ rod.grasps[0].tool)
    assert [move.action for move in moves(held, NEAR)] == [Open()]


def test_a_place_is_said_as_tasks_say_it():
    x, y = first_pose(BLOCKS, "red")[:2, 3]
    places = dict(BLOCKS.first()) | {"red": stood(BLOCKS, "red", 0.44, 0.30)}
    (move,) = moves(Arrangement(BLOCKS, places), NEAR)
    assert move.action == PutAt("red", (round(1000 * x, 3), round(1000 * y, 3)), degrees(0.0))


@pytest.mark.parametrize(("driver", "offers"), [("pa10", True), ("puma", True), ("mercury", False), ("so101", False)])
def test_arms_that_see_their_objects_offer_it_to_staff_alone(driver, offers):
    found = [one for one in offered_procedures(driver) if one.kind == "tidy"]
    assert (len(found) == 1) is offers
    assert (spec_of(driver).capability(Tidy) is not None) is offers
    if offers:
        assert found[0].asked_by == {STAFF}
        setting = next(one for one in spec_of(driver).settings() if one.name == "tidy_s")
        assert (setting.default, setting.low) == (0.0, 0.0), "not between turns, unless staff say so"
