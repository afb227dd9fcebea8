"""The driver against the simulator over a real pty, under every fault."""

import threading
from contextlib import contextmanager

import pytest

from robots.kit.contract.errors import (
    BadRequest,
    ControllerRefused,
    ControllerRestarted,
    HardwareFault,
    LineSilent,
    MotionHeld,
)
from tests.conftest import wait_for

pytestmark = pytest.mark.timed

SLOWLY = pytest.mark.parametrize("speed", [0.025])  # m/s: the faults of a test come while the arm is on its way


def allow():
    pass


def do(driver, kind, permit=allow, **args):
    stages = []
    outcome = driver.execute(kind, args, permit, stages.append)
    return outcome, stages


@contextmanager
def on_the_way(sim, act):
    """Call `act` once the arm, at home at first, is 1 cm on its way to the left."""

    def work():
        wait_for(lambda: sim.status()["pose"][0] < -0.01, 10, "a motion")
        act()

    thread = threading.Thread(target=work)
    thread.start()
    yield
    thread.join(15)


def test_every_command_reaches_its_place(ready, sim):
    outcome, stages = do(ready, "move", x=0.1, y=0.5)
    assert stages == ["sent", "acknowledged"]
    assert outcome.state.pose[:3] == pytest.approx((0.1, 0.5, 0.075), abs=2e-4)
    do(ready, "down")
    assert sim.status()["pose"][:3] == pytest.approx((0.1, 0.5, 0.0), abs=2e-4)
    assert do(ready, "air")[0].sent == {"seconds": 0.15}
    assert sim.count("burst") == 1
    do(ready, "up")
    do(ready, "home")
    assert sim.status()["pose"][:3] == pytest.approx((0.0, 0.42, 0.075), abs=2e-4)


def test_no_air_is_blown_from_above(ready, sim):
    with pytest.raises(BadRequest, match="Down first"):
        do(ready, "air")
    assert sim.count("burst") == 0


def test_an_uncalibrated_arm_refuses_to_move(driver, sim):
    driver.connect()
    with pytest.raises(ControllerRefused, match="not calibrated"):
        do(driver, "down")
    assert sim.count("motion") == 0


@pytest.mark.parametrize("verb", ["corrupt", "drop", "double"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_noisy_line_costs_time_never_a_wrong_move(ready, sim, verb, seed):
    sim.fault(verb, 0.03, seed=seed)
    targets = [(0.05, 0.40), (-0.05, 0.44), (0.0, 0.5)]
    for x, y in targets:
        try:
            outcome, _ = do(ready, "move", x=x, y=y)
        except HardwareFault:
            sim.clear()
            ready.recover(allow)
        else:
            assert outcome.state.pose[:2] == pytest.approx((x, y), abs=3e-4)
    sim.clear()
    allowed = {(round(x, 3), round(y, 3)) for x, y in [*targets, (0.0, 0.42)]}
    for record in sim.journal():
        if record["event"] == "motion":
            assert (round(record["target"][0], 3), round(record["target"][1], 3)) in allowed


def test_a_line_too_noisy_to_use_ends_as_a_fault_after_ten_resends(ready, sim):
    before = sim.count("motion")
    sim.fault("corrupt", 0.6, seed=3)
    with pytest.raises(LineSilent, match="11 tries"):
        do(ready, "down")
    assert ready.line.resent >= 10
    sim.clear()
    assert sim.count("motion") <= before + 1
    ready.recover(allow)


def test_acknowledgements_that_come_twice_move_once(ready, sim):
    sim.fault("double_ack")
    before = sim.count("motion")
    do(ready, "down")
    do(ready, "up")
    assert sim.count("motion") == before + 2


def test_late_acknowledgements_are_resent_for_and_move_once(ready, sim):
    sim.fault("slow", 0.5)
    before = sim.count("motion")
    do(ready, "down")
    assert ready.line.resent >= 1
    assert sim.count("motion") == before + 1


def test_a_hold_between_two_steps_of_a_jog_ends_it(ready, sim):
    steps = []

    def on_stage(stage):
        steps.append(stage)

    def permit():
        """Hold as another thread would, where a step has just ended."""
        if len(steps) == 4:
            steps.append("held")
            ready.hold()

    with pytest.raises(MotionHeld, match="stopped on its way"):
        ready.execute("jog", {"dx": 0.0, "dy": 1.0}, permit, on_stage)
    assert steps[4:] == ["held"], "no step began after the hold"


def test_a_silent_controller_is_a_fault_and_recovers_by_soft_reset(ready, sim):
    sim.fault("awol")
    with pytest.raises(LineSilent):
        do(ready, "down")
    sim.clear()
    state = ready.recover(allow)
    assert state.ready
    assert state.pose[2] == pytest.approx(0.075, abs=1e-3), "back at the previous position"
    assert sim.count("calibrate") == 2


def test_lost_power_is_noticed_and_nothing_is_repeated(ready, sim):
    do(ready, "down")
    before = sim.count("motion")
    sim.fault("power_cycle", count=1)
    with pytest.raises((ControllerRestarted, ControllerRefused, LineSilent)):
        do(ready, "up")
    assert sim.count("motion") == before
    assert ready.recover(allow).ready
    assert sim.status()["pose"][2] == pytest.approx(0.0, abs=1e-3)


@SLOWLY
def test_a_limit_switch_in_mid_motion_is_a_fault(ready, sim):
    with on_the_way(sim, lambda: sim.fault("limit_hit", count=1)), pytest.raises(HardwareFault):
        do(ready, "move", x=-0.2, y=0.3)
    assert ready.recover(allow).ready


def test_drift_is_noticed(ready, sim):
    sim.fault("drift", 3.0)
    with pytest.raises(HardwareFault, match="away from its target"):
        do(ready, "move", x=0.1, y=0.5)


def test_a_reconnected_driver_counts_on_after_the_controllers_newest_number(ready, sim):
    do(ready, "down")
    ready.close()
    other = type(ready)(str(sim.folder / "tty"), {})
    other.connect()
    before = sim.count("motion")
    do(other, "up")
    assert sim.count("motion") == before + 1
    other.close()


def test_sequence_numbers_go_round(ready, sim):
    before = sim.count("motion")
    for i, after in enumerate((100, 200, 253)):
        ready.line.start_after(after)
        do(ready, "down" if i % 2 == 0 else "up")
    do(ready, "up")
    do(ready, "down")
    do(ready, "up")
    assert ready.line._seq < 10
    assert sim.count("motion") == before + 6


def test_the_bed_survives_a_restart_of_the_simulator(ready, sim):
    (sim.folder / "bed.npy").unlink(missing_ok=True)
    do(ready, "down")
    do(ready, "air", seconds=0.5)
    wait_for((sim.folder / "bed.npy").exists, 5, "the bed")
    kept = (sim.folder / "bed.npy").read_bytes()
    ready.close()
    sim.stop()
    sim.start()
    assert (sim.folder / "bed.npy").read_bytes() == kept
    assert sim.status()["pose"][2] == pytest.approx(0.0, abs=1e-3)
