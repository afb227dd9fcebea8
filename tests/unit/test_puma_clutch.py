"""Bricks of the PUMA 560's cell hold together when they are pressed on at a place of the studs, and not otherwise."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from robots.kit.description import load
from simulators.puma.cell import bearers, bricks, plate_place
from simulators.puma.plant import Plant
from tests.puma_operator import Operator

CLUTCH = load("puma")["clutch"]
PITCH, STUD, HIGH = load("puma")["plate"]["pitch_m"], CLUTCH["stud_m"], 0.0192
WORK_J = 15.0 * 2 * STUD  # of 15 N on the way through the studs; a step of 2 ms rounds it up


def laid(x=0.0, y=0.0, turn=0.0, place=(0, 0), quarters=0):
    """Return an operator, with brick `e` on the studs of `a`, off by x, y (m) and turn (degrees) from a place."""
    one = Operator()
    off = np.array(place) * PITCH + [x, y]
    at = one.plant.place("a")
    one.put("e", *(at[:2] + off), at[2] + HIGH + STUD + 0.0002, np.radians(90 * quarters + turn))
    one.wait(0.1)
    return one


def between(one):
    """Return where `e` is from `a` (m)."""
    return one.plant.place("e") - one.plant.place("a")


angles = st.floats(0.0, 2 * np.pi)
SOME = settings(max_examples=12, deadline=None, phases=[Phase.explicit, Phase.generate])  # each one takes 0.1 s


@SOME
@given(angles, st.floats(0.0, 0.0013), st.floats(-2.7, 2.7), st.sampled_from([(0, 0), (1, 0), (-1, 0)]))
def test_a_brick_pressed_on_within_the_tolerances_is_held_exactly_at_its_place(angle, off, turn, place):
    one = laid(off * np.cos(angle), off * np.sin(angle), turn, place)
    assert one.plant.clutch.held() == set(), "laid down is not pressed"
    assert one.pull("e", (0, 0, -15), 0.12) < WORK_J
    one.wait(0.3)
    assert one.plant.clutch.held() == {("e", "a")}
    assert between(one) == pytest.approx([*(np.array(place) * PITCH), HIGH], abs=1e-4)
    assert abs(one.plant.pose("e")[:3, :3] - one.plant.pose("a")[:3, :3]).max() < 0.005
    assert one.energy("e") < 1e-8


@SOME
@given(angles, st.sampled_from([(0.002, 0.0), (0.004, 0.0), (0.0, 4.0), (0.0, -7.0)]))
def test_a_brick_off_by_2_mm_or_4_degrees_lies_on_the_studs_however_hard_it_is_pressed(angle, off):
    one = laid(off[0] * np.cos(angle), off[0] * np.sin(angle), off[1])
    one.pull("e", (0, 0, -30), 0.2)
    one.wait(0.2)
    assert one.plant.clutch.held() == set()
    assert between(one)[2] == pytest.approx(HIGH + STUD, abs=1e-4)
    assert one.plant.pose("e")[2, 2] > 0.9999


def test_a_brick_half_beside_the_studs_tilts():
    one = laid(place=(0, 0), x=0.0, y=0.0301)
    one.wait(0.5)
    assert one.plant.clutch.held() == set()
    assert one.plant.pose("e")[2, 2] < 0.99


def test_a_brick_across_another_is_held_where_there_are_studs_and_not_on_the_flat_middle():
    one = laid(place=(1, 0), quarters=1)
    one.pull("e", (0, 0, -15), 0.12)
    assert one.plant.clutch.held() == {("e", "a")}
    one = laid(quarters=1)
    one.pull("e", (0, 0, -15), 0.12)
    assert one.plant.clutch.held() == set()


def test_a_brick_holds_until_it_is_pulled_off_with_the_force_of_the_description():
    one = laid()
    one.pull("e", (0, 0, -15), 0.12)
    one.wait(0.3)
    one.plant.data.xfrc_applied[one.plant.model.body("a").id, 2] = -30.0  # somebody holds it down
    one.pull("e", (0, 0, CLUTCH["pull_n"] - 0.5), 0.3)
    assert one.plant.clutch.held() == {("e", "a")}
    assert between(one)[2] < HIGH + 0.0005
    one.pull("e", (0, 0, CLUTCH["pull_n"] + 1.0), 0.06)
    assert one.plant.clutch.held() == set()
    assert between(one)[2] > HIGH + STUD


def tower(one):
    """Build all bricks on each other on the plate, pressing each on."""
    x, y, z = plate_place()
    for n, name in enumerate(bricks()):
        one.put(name, x, y, z + 0.002 + HIGH * (n + 0.5) + STUD + 0.0002)
        one.wait(0.05)
        one.pull(name, (0, 0, -15), 0.15)
        one.wait(0.1)
    names = [*bricks()]
    return set(zip(names, ["plate", *names], strict=False))


def test_a_tower_of_five_stays_at_rest_and_parts_at_the_top():
    one = Operator()
    built = tower(one)
    assert one.plant.clutch.held() == built
    one.wait(0.5)
    before, most = one.plant.qpos, 0.0
    for _ in range(100):
        one.wait(0.1)
        most = max(most, *(one.energy(name) for name in bricks()))
    assert np.abs(one.plant.qpos - before).max() < 2e-5
    assert most < 1e-9
    assert one.plant.clutch.held() == built
    again = Plant(qpos=one.plant.qpos)
    assert again.clutch.held() == built, "also after a restart"
    force = 8.0
    while one.plant.clutch.held() == built and force < 20.0:
        force += 0.25
        one.pull("e", (0, 0, force), 0.04)
    assert one.plant.clutch.held() == built - {("e", "d")}
    assert force == pytest.approx(CLUTCH["pull_n"], abs=1.0)


def test_the_plate_has_a_stud_at_each_place_and_a_brick_a_flat_middle():
    *some, plate = bearers()
    assert len(plate.studs) == 100
    assert {len(one.studs) for one in some} == {4}
    assert np.unique(np.round(np.diff(np.unique(plate.studs[:, 0].round(6))), 5)).tolist() == [PITCH]
