"""Power-on, restart and watchdog in every state of every robot: it comes up again, at rest, and nothing in it dies."""

import itertools
import signal
import subprocess
import sys

import numpy as np
import pytest
from psutil import Process

from robots.kit.clock import SYSTEM
from simulators.mercury.controller import RESET_S
from tests.conftest import wait_for
from tests.drivers import irat_wire
from tests.drivers.conftest import CORRIDOR
from tests.drivers.mercury_wire import AIR, CALIBRATE, HOLD, MOVE_XYZ, floats
from tests.drivers.mercury_wire import Terminal as MercuryTerminal
from tests.drivers.pa10_wire import FASTER, Terminal, journal, push_out
from tests.rig import ArmSimulator, IratSimulator, Simulator
from tests.waiting import CEILING_S

SILENT_S = 3.0 * FASTER  # of an owner, and of a line to which nobody connects, before the arm's watchdog acts
EPOCHS = itertools.count(1)  # of the arms of this file


def claimed(sim):
    terminal = Terminal(sim)
    assert terminal.ask(f"i {next(EPOCHS)}").startswith("ok epoch")
    return terminal


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    sim = ArmSimulator(tmp_path_factory.mktemp("watched"), watchdog=SILENT_S, nobody=SILENT_S, speed=FASTER)
    yield sim
    sim.stop()


def at_rest(terminal, sim):
    """Bring the arm home, whatever state it is in."""
    sim.clear()
    terminal.ask("h")
    terminal.ask("b")
    if terminal.ask("W") == "e":
        assert terminal.ask("j 0 0 0 0 0 0").startswith("ok")
        assert terminal.ask("W") == "a"
    assert terminal.ask("j 0 25 75 0 80 0 1").startswith("ok")
    assert terminal.ask("W") == "a"


def leaving(terminal, sim):
    push_out(terminal, sim)
    assert terminal.ask("j 0 0 0 0 0 0 0.2").startswith("ok")


def asked(*lines):
    def ask(terminal, sim):
        for line in lines:
            assert terminal.ask(line).startswith("ok"), line

    return ask


ARM = {
    "at rest": (asked(), "a"),
    "on a path": (asked("j 90 25 75 0 80 0 0.1"), "a"),
    "driven by velocities": (asked("J 0 0 0 0 0 10"), "a"),
    "in a program": (asked("p 1"), "a"),
    "closing its gripper": (asked("g 1"), "a"),
    "inside a box that was added": (asked("b -2000 -2000 -2000 2000 2000 2000 everywhere"), "a"),
    "pushed out": (push_out, "e"),
    "on its way out of a range error": (leaving, "e"),
}


def ended_by(sim, why):
    """Return how often its application has ended for this reason."""
    return sum(why in record["why"] for record in journal(sim, "application"))


@pytest.mark.timed
@pytest.mark.parametrize("state", ARM)
def test_the_museum_arm_begins_again_in_every_state(watched, state):
    enter, letter = ARM[state]
    if watched.process.poll() is not None:
        watched.start()
    watched.forget()
    terminal = claimed(watched)
    at_rest(terminal, watched)
    boot = watched.status()["boot"]
    enter(terminal, watched)
    watched.fault("restart", count=1)
    wait_for(lambda: watched.status()["boot"] > boot, 20, "the restart")
    again = claimed(watched)
    assert again.ask("w") == letter
    assert not watched.status()["moving"]
    wait_for(lambda: ended_by(watched, "no line"), 30, "the watchdog")
    wait_for(lambda: ended_by(watched, "nobody"), 30, "nobody")
    assert claimed(watched).ask("w") == letter
    watched.stop()
    watched.start()
    assert claimed(watched).ask("w") == letter, "switched off and on where it stands"
    before = ended_by(watched, "no line")
    wait_for(lambda: ended_by(watched, "no line") > before, 30, "the watchdog")
    assert not journal(watched, "thread_died")
    assert not journal(watched, "crash")
    assert "watchdog" in watched.status()["threads"]
    assert watched.process.poll() is None


def test_the_museum_arm_that_is_switched_on_in_range_error_says_so(tmp_path):
    """Judged by order: it answers, its watchdog cuts the silent owner off, and the way out leads out."""
    sim = ArmSimulator(tmp_path, watchdog=SILENT_S, nobody=600.0 * FASTER, speed=FASTER)
    try:
        push_out(claimed(sim), sim)
        sim.stop()
        sim.start()
        silent = claimed(sim)
        assert silent.ask("w") == "e"
        boot = sim.status()["boot"]
        assert silent.hear() == "", "the watchdog ends the connection"
        wait_for(lambda: sim.status()["boot"] > boot, CEILING_S, "the restart")
        owner = claimed(sim)
        assert owner.ask("w") == "e"
        assert owner.ask("j 0 0 0 0 0 0").startswith("ok")
        assert owner.ask("W") == "a"
        assert not journal(sim, "thread_died")
    finally:
        sim.stop()


@pytest.mark.timed
@pytest.mark.parametrize("left", [b"", b"\x93NUMPY", "a pose that is not finite"])
def test_a_scene_that_cannot_be_read_is_a_new_one(tmp_path, left):
    sim = ArmSimulator(tmp_path)
    sim.stop()
    scene = tmp_path / "scene.npy"
    if isinstance(left, bytes):
        scene.write_bytes(left)
    else:
        np.save(scene, np.full_like(np.load(scene), np.nan))
    sim.start()
    try:
        assert claimed(sim).ask("w") == "a"
    finally:
        sim.stop()


@pytest.mark.timed
def test_the_museum_arm_ends_without_its_cameras(tmp_path):
    sim = ArmSimulator(tmp_path)
    try:
        cameras = Process(sim.process.pid).children()[-1]  # started last
        cameras.kill()
        assert sim.process.wait(CEILING_S) == 1
        assert "its thread 'cameras' died" in (tmp_path / "said.log").read_text()
    finally:
        sim.stop()


def calibrated(line, sim):
    return line.calibrated(1)


def mercury_moving(line, sim):
    seq = calibrated(line, sim)
    line.ask(MOVE_XYZ, seq + 1, floats(150.0, 500.0, 75.0))
    return seq + 1


def mercury_held(line, sim):
    line.ask(HOLD, mercury_moving(line, sim) + 1)


def mercury_limited(line, sim):
    sim.fault("limit_hit", count=1)
    mercury_moving(line, sim)


def mercury_blowing(line, sim):
    seq = calibrated(line, sim)
    line.ask(MOVE_XYZ, seq + 1, floats(0.0, 450.0, 0.0))
    assert line.ended(seq + 1)
    line.ask(AIR, seq + 2, floats(1.0))


MERCURY = {
    "switched on": lambda line, sim: None,
    "calibrating": lambda line, sim: line.ask(CALIBRATE, 1),
    "at rest": calibrated,
    "moving": mercury_moving,
    "held": mercury_held,
    "at a limit switch": mercury_limited,
    "blowing": mercury_blowing,
}


@pytest.mark.timed
@pytest.mark.parametrize("state", MERCURY)
def test_the_mercury_arm_begins_again_in_every_state(tmp_path, state):
    sim = Simulator(tmp_path, speed=FASTER)
    try:
        for off_and_on in (sim.power_cycle, lambda: stopped(sim), lambda: killed(sim)):
            SYSTEM.sleep(RESET_S)  # for so long it hears nothing
            line = MercuryTerminal(tmp_path / "tty")
            MERCURY[state](line, sim)
            boot = sim.status()["boot"]
            off_and_on()
            line.close()
            sim.clear()
            assert sim.status()["boot"] > boot
            assert not sim.status()["moving"]
            SYSTEM.sleep(RESET_S)
            line = MercuryTerminal(tmp_path / "tty")
            calibrated(line, sim)
            line.close()
            sim.power_cycle()
        assert not sim.count("thread_died")
    finally:
        sim.stop()


def stopped(sim):
    sim.stop()
    sim.start()


def killed(sim):
    sim.process.send_signal(signal.SIGKILL)
    sim.process.wait(CEILING_S)
    sim.start()


@pytest.fixture(scope="module")
def restarted_rat(tmp_path_factory):
    sim = IratSimulator(tmp_path_factory.mktemp("restarted_rat"), speed=irat_wire.FASTER)
    yield sim
    sim.stop()


def rat_driving(client, sim):
    client.claim()
    client.drive_far(sim, 0.05, 0.2)


def rat_held(client, sim):
    rat_driving(client, sim)
    client.say("call_service", id="held", service="/irat/hold", args={})


RAT = {
    "at rest": lambda client, sim: client.claim(),
    "driving": rat_driving,
    "held": rat_held,
    "carried": lambda client, sim: sim.fault("carried", CORRIDOR),
    "flat": lambda client, sim: sim.fault("charge", 0.021),
}


@pytest.mark.timed
@pytest.mark.parametrize("state", RAT)
def test_the_irat_begins_again_in_every_state(restarted_rat, state):
    sim = restarted_rat
    for off_and_on in (sim.power_cycle, lambda: stopped(sim), lambda: killed(sim)):
        sim.clear()
        sim.fault("charge", 0.9)
        sim.fault("carried", CORRIDOR)
        client = irat_wire.WireClient(sim)
        RAT[state](client, sim)
        boot = sim.status()["boot"]
        off_and_on()
        assert sim.status()["boot"] > boot
        sim.clear()
        sim.fault("charge", 0.9)
        wait_for(lambda: sim.status()["power"], 10, "the power")
        again = irat_wire.WireClient(sim)
        assert again.claim()["success"]
        assert not again.status()["moving"]
        again.drive_far(sim, 0.05, 0.2)
        again.close()
    assert not sim.count("thread_died")


@pytest.mark.timed
def test_the_irat_whose_port_is_taken_ends_with_a_word(tmp_path, restarted_rat):
    """Its network's thread cannot begin; the process must not wait for it."""
    port = restarted_rat.address.rpartition(":")[2]
    argv = [sys.executable, "-m", "simulators.irat", "--dir", str(tmp_path), "--port", port, "--open-floor"]
    ended = subprocess.run(argv, capture_output=True, text=True, timeout=CEILING_S, check=False)
    assert ended.returncode == 1
    assert "its thread 'network' died" in ended.stderr
