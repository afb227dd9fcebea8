"""The PUMA 560's controller in virtual time: what it begins, what it refuses, and what ends a motion."""

import random
from math import degrees, radians

import numpy as np
import pytest

from robots.kit.arms.described import chain
from robots.kit.drivers.puma.protocol import End, Error, Flag, Instruction, Mode
from tests.world.puma_cell import Cell
from tests.world.world import World

READY = (15_000, 55_000, 85_000, 0, 40_000, 15_000)
UPRIGHT = (0,) * 6
STILL_RAD = radians(0.05)
BRAKES_S = 0.6


@pytest.fixture
def begin(tmp_path):
    """Begin a world with a cell; the one before is closed."""
    opened = []

    def begun(seed=1, **more) -> Cell:
        opened.append(Cell(World(seed), tmp_path / str(len(opened)), **more))
        return opened[-1]

    yield begun
    for cell in opened:
        cell.world.check_errors()
        cell.world.close()
        cell.sim.journal.close()


@pytest.fixture
def cell(begin):
    made = begin()
    made.calibrate()
    return made


def each_motion(cell, seconds):
    """Return an instruction of each kind that moves something, with the clock after which it must not begin."""
    latest = cell.latest(seconds)
    return [
        (Instruction.JOINTS, latest, 500, *READY),
        (Instruction.POSE, latest, 500, 60_000, 10_000, 40_000, 180_000, 0, 180_000),
        (Instruction.LINE, latest, 500, 0, -15_000, 130_000, 0, 0, 0),
        (Instruction.JOG_JOINTS, latest, 20_000, 0, 0, 0, 0, 0),
        (Instruction.JOG_TOOL, latest, 0, 0, -5_000, 0, 0, 0),
        (Instruction.GRIP, latest, 1),
        (Instruction.CALIBRATE, latest),
    ]


def test_nothing_moves_before_the_calibration_which_moves_each_joint_and_returns(begin):
    cell = begin()
    for what, *numbers in each_motion(cell, 60)[:-1]:
        assert cell.ask(what, *numbers) == Error.NOT_CALIBRATED
    at, began = cell.q, cell.world.monotonic()
    assert cell.move(Instruction.CALIBRATE) is None
    most = np.zeros(6)
    while (state := cell.state()).mode == Mode.CALIBRATING:
        most = np.maximum(most, np.abs(cell.q - at))
        assert Flag.CALIBRATED not in state.flags
    assert (state.mode, state.end, state.flags) == (Mode.IDLE, End.DONE, Flag.CALIBRATED)
    assert cell.world.monotonic() - began >= 2.0
    assert (most > radians(2.5)).all()
    assert cell.q == pytest.approx(at, abs=STILL_RAD)


def test_joints_are_told_coarsely_before_the_calibration_and_exactly_after_it(begin):
    cell = begin()
    cell.calibrate()
    cell.move(Instruction.JOINTS, 1000, 1_160, 0, 0, 0, 0, 0)
    assert degrees(cell.at_rest().joints[0]) == pytest.approx(1.16, abs=0.01)
    assert cell.ask(Instruction.RESET) is None
    assert degrees(cell.state().joints[0]) == pytest.approx(1.2, abs=1e-6)


@pytest.mark.parametrize("seconds", [1, 2, 5, 20, 60])
def test_what_a_stalled_line_delivers_late_moves_nothing(cell, seconds):
    before, at = {event: cell.count(event) for event in ("motion", "gripper")}, cell.q
    late = each_motion(cell, 0.9)
    cell.cable.stall(seconds)
    numbers = [cell.send(what, *about) for what, *about in late]
    refused = [cell.answer(seq, seconds + 3).numbers[2] for seq in numbers[-1:]]
    assert refused == [Error.TOO_LATE]
    cell.world.sleep(1.0)
    assert {event: cell.count(event) for event in before} == before
    assert cell.count("late") == len(late)
    assert cell.q == pytest.approx(at, abs=STILL_RAD)
    assert cell.move(Instruction.JOINTS, 1000, 2000, 0, 0, 0, 0, 0) is None
    assert cell.at_rest().end == End.DONE


def test_what_waited_behind_other_lines_on_a_slow_line_is_late_too(begin):
    cell = begin(baud=9600)
    cell.calibrate()
    latest, before = cell.latest(), cell.count("motion")
    for _ in range(100):  # a second and a half of the line
        cell.send(Instruction.STATUS)
    seq = cell.send(Instruction.JOINTS, latest, 500, *READY)
    assert cell.answer(seq, 20.0).numbers[2] == Error.TOO_LATE
    assert cell.count("motion") == before


def test_a_motion_that_is_held_while_it_is_planned_never_begins(cell):
    cell.planner.takes_s, before = 0.5, cell.count("motion")
    assert cell.move(Instruction.JOINTS, 500, *READY) is None
    assert cell.state().mode == Mode.PLANNING, "a state is told meanwhile"
    assert cell.move(Instruction.JOINTS, 500, *READY) == Error.BUSY
    assert cell.ask(Instruction.HOLD) is None
    state = cell.state()
    assert (state.mode, state.end) == (Mode.IDLE, End.HELD)
    cell.world.sleep(1.0)
    assert cell.count("motion") == before
    cell.planner.takes_s = 0.01
    assert cell.move(Instruction.JOINTS, 1000, 3000, 0, 0, 0, 0, 0) is None
    assert cell.at_rest().end == End.DONE
    assert degrees(cell.q[0]) == pytest.approx(3.0, abs=0.05), "the held motion's plan is not taken for the next"


def test_a_motion_whose_planning_takes_too_long_never_begins(cell):
    cell.planner.takes_s, before = 1.2, cell.count("motion")
    assert cell.move(Instruction.JOINTS, 500, *READY) is None
    state = cell.at_rest()
    assert (state.end, state.why) == (End.REFUSED, Error.TOO_LATE)
    assert cell.count("motion") == before


@pytest.mark.parametrize(
    ("what", "numbers", "why"),
    [
        (Instruction.JOINTS, (500, 170_000, 0, 0, 0, 0, 0), Error.OUT_OF_RANGE),
        (Instruction.JOINTS, (10, *READY), Error.OUT_OF_RANGE),
        (Instruction.POSE, (500, 150_000, 0, 0, 0, 0, 0), Error.OUT_OF_RANGE),
        (Instruction.POSE, (500, 60_000, 10_000, 100, 180_000, 0, 180_000), Error.IN_BOX),
    ],
)
def test_a_motion_that_cannot_be_is_refused_after_it_was_planned(cell, what, numbers, why):
    assert cell.move(what, *numbers) is None
    state = cell.at_rest()
    assert (state.end, state.why) == (End.REFUSED, why)


def test_a_box_is_kept_out_of_until_the_boxes_are_taken_away(cell):
    target = (500, 60_000, 10_000, 30_000, 180_000, 0, 180_000)
    assert cell.ask(Instruction.BOX, 55_000, 5_000, 20_000, 65_000, 15_000, 50_000) is None
    assert cell.move(Instruction.POSE, *target) is None
    assert cell.at_rest().why == Error.IN_BOX
    assert cell.ask(Instruction.BOX) is None
    assert cell.move(Instruction.POSE, *target) is None
    assert cell.at_rest().end == End.DONE


def test_a_velocity_ends_unless_it_is_repeated(cell):
    began = cell.world.monotonic()
    assert cell.move(Instruction.JOG_JOINTS, 20_000, 0, 0, 0, 0, 0) is None
    state = cell.at_rest()
    assert cell.world.monotonic() - began < 0.25 + BRAKES_S
    assert state.end == End.DONE
    assert 2.0 < degrees(cell.q[0]) < 7.0
    assert cell.count("motion") == 2, "the calibration and this one"


def test_repeated_velocities_are_one_motion_that_another_velocity_replaces_and_a_hold_ends(cell):
    latest = cell.latest(60)
    first = cell.send(Instruction.JOG_JOINTS, latest, 20_000, 0, 0, 0, 0, 0)
    for _ in range(9):
        cell.world.sleep(0.1)
        assert cell.ask(Instruction.JOG_JOINTS, latest, 20_000, 0, 0, 0, 0, 0) is None
    there = degrees(cell.q[0])
    assert there > 14.0
    for _ in range(8):
        cell.world.sleep(0.1)
        assert cell.ask(Instruction.JOG_TOOL, latest, 0, 0, -5_000, 0, 0, 0) is None
        assert cell.state().mode == Mode.JOGGING
    assert cell.state().motion == first
    assert cell.move(Instruction.JOINTS, 500, *READY) == Error.BUSY
    assert cell.ask(Instruction.JOG_JOINTS, latest, 20_000, 0, 0, 0, 0, 0) is None
    assert cell.ask(Instruction.HOLD) is None
    state = cell.at_rest(BRAKES_S)
    assert (state.motion, state.end) == (first, End.HELD)
    assert cell.count("motion") == 2


def test_a_hold_comes_to_rest_under_any_number(cell):
    for seq in (cell.seq - 40, cell.seq, cell.seq + 100):
        assert cell.move(Instruction.JOINTS, 500, *READY) is None
        cell.world.sleep(0.5)
        assert cell.state().mode == Mode.MOVING
        assert cell.ask(Instruction.HOLD, seq=seq % 256) is None
        assert cell.at_rest(BRAKES_S).end == End.HELD
        cell.seq = max(cell.seq, seq)
    assert cell.count("passed") == 0


def test_nothing_is_done_twice_and_nothing_under_an_old_number(cell):
    latest, seq = cell.latest(60), (cell.seq + 1) % 256
    first = [cell.ask(Instruction.GRIP, latest, 1, seq=seq) for _ in range(3)]
    assert (first, cell.count("gripper")) == ([None] * 3, 1)
    assert cell.ask(Instruction.JOINTS, latest, 500, *READY, seq=seq) is None, "the stored answer"
    assert cell.ask(Instruction.JOINTS, latest, 500, *READY, seq=(seq - 60) % 256) == Error.STALE_SEQUENCE
    cell.seq = seq
    assert cell.state().mode == Mode.IDLE
    assert cell.count("motion") == 1, "the calibration"


def test_a_motion_is_held_where_the_host_is_silent_and_goes_on_where_it_asks(cell):
    assert cell.move(Instruction.JOINTS, 200, *READY) is None
    for _ in range(10):
        cell.world.sleep(0.3)
        assert cell.state().mode == Mode.MOVING
    cell.cable.pull()
    cell.world.sleep(1.4)
    assert cell.sim.motions.moving
    cell.world.sleep(0.2 + BRAKES_S)
    assert not cell.sim.motions.moving
    cell.cable.plug()
    assert cell.state().end == End.HELD


@pytest.mark.parametrize("how", ["power", "reset"])
def test_a_power_cycle_in_mid_motion_ends_it_and_all_that_was_known(cell, how):
    assert cell.ask(Instruction.BOX, 0, 0, 150_000, 10_000, 10_000, 160_000) is None
    assert cell.move(Instruction.JOINTS, 1000, *READY) is None
    cell.world.sleep(0.8)
    boot = cell.state().boot
    assert cell.sim.motions.moving
    if how == "power":
        cell.sim.faults.set("power_cycle", count=1)
        cell.world.sleep(0.4)
    else:
        assert cell.ask(Instruction.RESET) is None
        cell.world.sleep(0.2)
    at = cell.q
    state = cell.state()
    assert (state.boot, state.mode, state.flags, state.end) == (boot + 1, Mode.IDLE, Flag.NONE, End.NONE)
    assert cell.sim.motions.boxes == ()
    cell.world.sleep(1.0)
    assert cell.q == pytest.approx(at, abs=STILL_RAD)
    assert cell.move(Instruction.JOINTS, 500, *READY) == Error.NOT_CALIBRATED
    cell.calibrate()
    assert cell.count("passed") == 0


def test_a_joint_that_does_not_follow_is_a_fault_which_only_a_reset_ends(cell):
    cell.sim.faults.set("disturb", 2000.0)
    cell.world.sleep(0.5)
    cell.sim.faults.clear()
    state = cell.state()
    assert Flag.FAULT in state.flags
    cell.world.sleep(1.0)
    for what, *numbers in each_motion(cell, 60):
        assert cell.ask(what, *numbers) == Error.FAULT
    assert cell.ask(Instruction.RESET) is None
    cell.calibrate()
    assert cell.state().flags == Flag.CALIBRATED


def test_a_fault_brakes_a_motion(cell):
    assert cell.move(Instruction.JOINTS, 500, *READY) is None
    cell.world.sleep(0.5)
    cell.sim.faults.set("limit_hit", count=1)
    cell.world.sleep(BRAKES_S)
    state = cell.state()
    assert (state.mode, state.end, state.flags) == (Mode.IDLE, End.HELD, Flag.CALIBRATED | Flag.FAULT)


def test_the_gripper_tells_its_valve_only_and_takes_its_time(cell):
    assert cell.move(Instruction.GRIP, 1) is None
    assert Flag.CLOSED in cell.state().flags
    assert cell.sim.plant.measured().opening > 0.02
    cell.world.sleep(0.5)
    assert cell.sim.plant.measured().opening < 0.001
    assert cell.ask(Instruction.RESET) is None
    assert Flag.CLOSED in cell.state().flags, "the valve stays"


@pytest.mark.parametrize("seed", range(2))
def test_no_set_point_leaves_ranges_speeds_or_boxes_whatever_is_asked_for(begin, seed):
    cell, dice = begin(seed), random.Random(seed)
    arm = chain("puma")
    cell.calibrate()
    for _ in range(3):
        joints = [round(degrees(dice.uniform(joint.low, joint.high)) * 1000) for joint in arm.joints]
        cell.move(Instruction.JOINTS, 1000, *joints)
        cell.world.sleep(dice.random())
        if dice.random() < 0.3:
            cell.ask(Instruction.HOLD)
        cell.at_rest()
        for _ in range(10):
            tool = dice.random() < 0.5
            speeds = [round(dice.uniform(-1, 1) * (40_000 if tool else 200_000)) for _ in range(6)]
            cell.move(Instruction.JOG_TOOL if tool else Instruction.JOG_JOINTS, *speeds)
            cell.world.sleep(dice.random() * 0.2)
        cell.at_rest()
    assert cell.count("passed") == 0
    assert cell.count("fault") == 0
    assert cell.sim.nearest[0] > 0, cell.sim.nearest


def test_it_stands_where_it_was_killed_under_a_new_boot_number(cell):
    assert cell.move(Instruction.JOINTS, 500, *READY) is None
    cell.world.sleep(0.7)
    at, boot = cell.q, cell.sim.controller.boot
    cell.world.kill(cell.process)
    cell.sim.journal.close()
    cell.start()
    assert cell.q == pytest.approx(at, abs=radians(2.5)), "a position is stored each 40 ms"
    state = cell.state()
    assert (state.boot, state.flags) == (boot + 1, Flag.NONE)
    cell.calibrate()
