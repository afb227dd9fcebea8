"""The cell of the PUMA 560: its gripper takes bricks and rod, encoders and places err a little, mishaps happen."""

from itertools import pairwise

import numpy as np
import pytest

from robots.kit.arms.described import chain, posture
from robots.kit.description import load
from simulators.common.faults import FaultBoard
from simulators.puma.cell import bricks, plate_place, things
from simulators.puma.errors import errors_of, kept_seed
from simulators.puma.mishaps import Mishaps
from simulators.puma.plant import Plant
from simulators.puma.rod import CEILING_M
from tests.puma_operator import Operator, down

HIGH, PLATE = 0.0192, 0.004
READY = posture(load("puma"), "ready")


def test_a_brick_is_lifted_carried_pressed_onto_the_plate_and_pulled_off_again():
    one = Operator()
    one.take(0.60, -0.24, HIGH / 2)
    in_hand = one.plant.place("a") - one.plant.place("tip")
    assert np.abs(in_hand).max() < 0.0005
    one.wait(1.0)
    assert np.abs(one.plant.place("a") - one.plant.place("tip") - in_hand).max() < 0.0001, "it slips"
    x, y, _ = plate_place()
    one.press(x, y, PLATE + HIGH / 2 - 0.001)
    assert one.plant.clutch.held() == {("a", "plate")}
    assert one.plant.place("a") == pytest.approx([x, y, PLATE + HIGH / 2], abs=2e-4)
    one.line(down(x, y, PLATE + HIGH / 2))
    one.grip()
    one.line(down(x, y, PLATE + 0.10), 0.1)
    assert one.plant.clutch.held() == set()
    assert one.plant.place("a")[2] == pytest.approx(PLATE + 0.10, abs=0.001)


def test_a_grip_is_weaker_than_a_hard_pull():
    one = Operator()
    one.take(0.60, -0.24, HIGH / 2)
    one.pull("a", (0, 0, -15.0), 0.2)
    held = one.plant.place("a") - one.plant.place("tip")
    assert np.abs(held).max() < 0.001
    one.pull("a", (0, 0, -90.0), 0.2)
    assert one.plant.place("a")[2] < one.plant.place("tip")[2] - 0.01


def test_the_rod_is_lifted_off_its_threads_and_swings_to_rest_after_a_release():
    one = Operator()
    one.wait(0.2)
    taut = one.plant.data.ten_length.copy()
    assert taut == pytest.approx(CEILING_M - 0.307, abs=0.001)
    one.take(0.55, 0.30, 0.30, high=0.03)
    slack = one.plant.data.ten_length
    assert (slack < taut - 0.028).all()
    one.line(down(0.55, 0.27, 0.33))
    one.release()
    one.line(down(0.55, 0.27, 0.43))
    width = [swing(one, 2.7) for _ in range(4)]
    assert width[0] > 0.01
    assert all(after < before for before, after in pairwise(width))
    decay = -2.7 * 3 / np.log(width[3] / width[0])
    assert 20 < decay * np.log(width[0] / 0.001) < 60, "seconds until it swings by less than 1 mm"


def swing(one, seconds):
    """Return how far (m) the rod swings to one side."""
    most = 0.0
    for _ in range(round(seconds / 0.02)):
        one.wait(0.02)
        most = max(most, abs(float(one.plant.place("rod")[1]) - 0.30))
    return most


def test_the_errors_of_a_seed_are_the_same_each_time_and_small(tmp_path):
    first, again, other = errors_of(7), errors_of(7), errors_of(8)
    assert np.array_equal(first.zeros, again.zeros)
    assert first.places == again.places
    assert not np.array_equal(first.zeros, other.zeros)
    every = [errors_of(seed) for seed in range(300)]
    assert np.degrees(np.std([one.zeros for one in every])) == pytest.approx(0.03, rel=0.1)
    assert np.std([one.tool for one in every]) == pytest.approx(0.0003, rel=0.1)
    places = np.array([list(one.places.values()) for one in every])
    assert places[..., :2].std() == pytest.approx(0.001, rel=0.1)
    assert np.degrees(places[..., 2].std()) == pytest.approx(1.0, rel=0.1)
    seed = kept_seed(tmp_path)
    assert kept_seed(tmp_path) == seed
    assert kept_seed(tmp_path, 5) == 5
    assert kept_seed(tmp_path) == 5
    (tmp_path / "seed").write_text("nonsense")
    assert kept_seed(tmp_path) == kept_seed(tmp_path)


def test_encoders_tell_the_posture_without_the_errors_of_their_zeros():
    errors = errors_of(3)
    plant = Plant(READY, errors=errors)
    assert plant.measured().q == pytest.approx(READY)
    told = chain("puma").forward(plant.measured().q)[:3, 3]
    true = chain("puma").forward(READY + errors.zeros)[:3, 3]
    assert plant.place("tip") == pytest.approx(true, abs=1e-9)
    assert 1e-5 < np.linalg.norm(true - told) < 0.003
    for name in bricks():
        off = plant.place(name) - things()[name].first[:3, 3]
        assert off[:2] == pytest.approx(errors.places[name][:2])
    pads = sum(plant.place(name) for name in ("left_pad", "right_pad")) / 2 - plant.place("tip")
    exact = Plant(READY + errors.zeros)
    straight = sum(exact.place(name) for name in ("left_pad", "right_pad")) / 2 - exact.place("tip")
    assert np.linalg.norm(pads - straight) == pytest.approx(np.linalg.norm(errors.tool), abs=1e-6)


class Cell(Operator):
    """An operator whose cell has mishaps."""

    def __init__(self):
        super().__init__()
        self.board = FaultBoard()
        mishaps = Mishaps(self.board, self.plant)
        self.seen.append(mishaps.step)
        self.mishaps = mishaps


def test_a_mug_stands_in_the_cell_while_it_is_set():
    one = Cell()
    one.wait(0.1)
    assert one.plant.place("mug")[0] < -1.5
    one.board.set("intrude")
    assert one.mishaps.busy
    one.wait(0.3)
    assert not one.mishaps.busy
    assert one.plant.place("mug") == pytest.approx([0.52, 0.10, 0.048], abs=1e-3)
    again = Plant(qpos=one.plant.qpos)
    Mishaps(FaultBoard(), again).step()
    assert again.place("mug")[0] < -1.5, "nobody asks for it after a restart"
    one.board.clear()
    one.wait(0.1)
    assert one.plant.place("mug")[0] < -1.5


def test_a_brick_is_away_while_it_is_set_and_then_where_it_was():
    one = Cell()
    one.wait(0.1)
    before = one.plant.place("c")
    one.board.set("vanish", 3)
    one.wait(0.3)
    assert one.plant.place("c")[0] < -1.5
    one.board.set("vanish", 4)
    one.wait(0.3)
    assert one.plant.place("c") == pytest.approx(before, abs=1e-4)
    assert one.plant.place("d")[0] < -1.5
    one.board.set("vanish", 77)
    one.wait(0.3)
    assert one.plant.place("d")[0] > 0.5


@pytest.mark.parametrize("along", [10.0, -15.0])
def test_a_nudge_pushes_a_brick_by_so_many_millimetres(along):
    one = Cell()
    one.wait(0.1)
    before = one.plant.place("a")
    one.board.set("nudge", along)
    one.wait(0.5)
    assert 1000 * (one.plant.place("a") - before) == pytest.approx([0.0, along, 0.0], abs=0.5)
    assert one.board.present() == {}
    assert not one.mishaps.busy


def test_a_gust_makes_the_rod_swing():
    one = Cell()
    assert swing(one, 0.5) < 1e-4
    one.board.set("gust", 3.0)
    assert swing(one, 3.0) > 0.02
    one.board.clear()
    assert swing(one, 1.0) > 0.01, "it swings on"
    assert one.plant.data.xfrc_applied.any() == False  # noqa: E712 - NumPy's own


def test_what_is_put_where_something_lies_is_put_on_it():
    plant = Plant(READY)
    x, y, z = plant.place("a")
    plant.put("b", np.array([x, y, z]), np.array([1.0, 0.0, 0.0, 0.0]))
    still = np.zeros(6)
    assert plant.place("b")[2] > z + HIGH
    for _ in range(300):
        plant.step(still, 0)
    assert np.abs(plant.place("a")[:2] - (x, y)).max() < 0.002
