"""What can go wrong with the museum arm in a turn: the line, the controller, the gripper, a push. Through the real worker."""

import socket
import time

import pytest

from robots.models import Command, Incident, Robot
from robots.states import Cycle, GrantEnd
from tests.conftest import at_length, wait_for

# ruff: noqa: TID251 - its tests are timed
pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["pa10"], indirect=True)]


@pytest.fixture
def line(rig):
    return rig.line_proxy()


def well(rig):
    """Wait until the arm is in order again by itself, and moves."""
    wait_for(lambda: not Robot.objects.get().reason, 60, "the robot is well")
    # a soft reset goes home and back first; a command that waits for it too long expires, in words
    wait_for(lambda: rig.final(rig.issue("move", x=0.0, y=0.4), 60).state == "completed", 90, "work goes on")


@pytest.mark.parametrize("stage", [at_length("idle"), "in motion"])
@pytest.mark.parametrize("how", ["cut", at_length("stall")])
def test_the_connection_breaks(rig, line, stage, how):
    rig.grant(seconds=600)
    rig.share = 0.05
    command = None
    if stage == "in motion":
        command = rig.issue("move", x=0.2, y=0.4)
        rig.moving()
    before = rig.sim.count("motion")
    line.set(how)
    if command:
        command = rig.final(command, 60)
        assert command.state in ("failed", "unknown"), command.state
        assert command.reason.endswith("."), command.reason
    wait_for(rig.reason, 30, "the page says what is wrong")
    assert "arm" in rig.reason()
    made = rig.sim.count("motion")
    assert made == before
    line.set("pass")
    rig.share = None
    well(rig)
    assert Incident.objects.exists()


def test_a_second_client_is_turned_away_and_disturbs_nothing(rig, line):
    rig.grant(seconds=600)
    command = rig.issue("move", x=0.1, y=0.4)
    rig.moving()
    host, _, port = (rig.sim.folder / "tty").read_text().strip().partition(":")
    with socket.create_connection((host, int(port)), timeout=5) as other:
        other.sendall(b"j 0 0 0 0 0 0\n")
        assert b"another client" in other.recv(200)
    assert rig.final(command).state == "completed"


def test_a_range_error_in_mid_turn(rig):
    """Pushed into the cables: the command fails in words, the default position leads out, and work goes on."""
    rig.owner()
    rig.grant(seconds=600)
    posture = {"S1": 2.6, "S2": -0.7, "E1": -0.7, "E2": 0.0, "W1": -0.5, "W2": 0.0}
    first = rig.final(rig.issue("joints", **posture), 60)
    assert first.state == "completed", first.reason
    command = rig.issue("joints", **posture | {"S1": 1.8, "speed": 0.1})  # it is on its way for long enough
    rig.moving()
    rig.sim.fault("disturb", 3000.0)
    command = rig.final(command, 60)
    rig.sim.clear()
    assert (command.state, "Range error" in command.reason) == ("failed", True), command.reason
    well(rig)
    assert Incident.objects.filter(command=command).exists()
    events = [r["event"] for r in rig.sim.journal()]
    assert "range_error" in events


def test_the_watchdog_restarts_the_application_during_a_program(rig):
    rig.owner()
    rig.grant(seconds=600)
    text = "R 10\nj 20 25 75 0 80 0 0.1\nj -20 25 75 0 80 0 0.1\nE"
    command = rig.issue("program", text=text)
    rig.robot_shows(lambda status: status["mode"] == "PROG_EXEC", 20, "the program runs")
    rig.sim.fault("restart", count=1)
    command = rig.final(command, 60)
    assert command.state in ("failed", "unknown"), command.state
    assert command.reason
    well(rig)
    steps = rig.sim.count("motion")
    rig.swept()
    assert rig.sim.status()["mode"] != "PROG_EXEC"
    assert rig.sim.count("motion") == steps, "a program that was broken off does not go on"


def test_a_program_is_held_by_a_stop_and_by_the_end_of_the_turn(rig):
    from robots import services
    from robots.kit.clock import SYSTEM

    rig.owner()
    grant = rig.grant(seconds=600)
    text = "R 20\nj 20 25 75 0 80 0 0.2\nj -20 25 75 0 80 0 0.2\nE"
    command = rig.issue("program", text=text)
    rig.robot_shows(lambda status: status["mode"] == "PROG_EXEC", 20, "the program runs")
    time.sleep(0.5)
    services.end_grant(grant, GrantEnd.STAFF, "the test ends it", SYSTEM.now())
    command = rig.final(command, 20)
    assert command.state == "cancelled", (command.state, command.reason)
    wait_for(lambda: not rig.sim.status()["moving"], 5, "rest")
    made = rig.sim.count("motion")
    rig.swept()
    assert rig.sim.status()["mode"] != "PROG_EXEC"
    assert rig.sim.count("motion") == made


def test_a_dropped_block_is_no_fault_and_the_turn_goes_on(rig):
    rig.owner()
    rig.grant(seconds=600)
    x, y, _ = rig.sim.status()["objects"]["blue"]
    down = {"roll": 3.14159265, "pitch": 0.0, "yaw": 3.14159265}

    def done(kind, **args):
        command = rig.final(rig.issue(kind, **args), 60)
        assert command.state == "completed", (kind, args, command.reason)

    done("gripper", closed=0)  # a test before may have left it closed
    for kind, z in (("pose", 0.15), ("line", 0.022)):
        done(kind, x=x, y=y, z=z, **down)
    done("gripper", closed=1)
    done("line", x=x, y=y, z=0.15, **down)
    assert rig.sim.status()["objects"]["blue"][2] > 0.1
    rig.sim.fault("slip", count=1)
    wait_for(lambda: rig.sim.status()["objects"]["blue"][2] < 0.03, 10, "the fall")
    assert rig.final(rig.issue("noop"), 20).state == "completed"
    assert Robot.objects.get().reason == ""


def test_a_newer_target_takes_the_place_of_the_one_before(rig):
    rig.owner()
    rig.grant(seconds=600)
    rig.share = 0.1
    first = rig.issue("move", x=0.2, y=0.4)
    rig.moving()
    time.sleep(0.4)
    second = rig.issue("move", x=-0.1, y=0.4)
    first, second = rig.final(first, 30), rig.final(second, 60)
    assert (first.state, first.reason) == ("cancelled", "Replaced: a newer target took its place.")
    assert second.state == "completed"
    ends = [r for r in rig.sim.journal() if r["event"] == "end"]
    assert ends[-2]["end"] == "replaced"
    assert not any(r["event"] == "hold" for r in rig.sim.journal()[-6:]), "it blends, it does not stop between"
    assert Command.objects.filter(state="cancelled").count() == 1


def test_pushed_into_a_range_error_while_nobody_has_it_it_is_put_in_order_before_it_is_offered(rig):
    rig.owner()
    rig.sim.fault("disturb", 3000.0)
    found = Incident.objects.filter(code="hardware_fault", text__contains="Range error")
    wait_for(found.exists, 30, "the robot's word is heard")
    wait_for(lambda: rig.cycle() != Cycle.READY, 10, "it is taken back")  # told after the incident
    rig.sim.clear()
    rig.wait_ready(90)
    assert rig.sim.status()["mode"] != "RANGE_ERROR"
    rig.grant()
    assert rig.final(rig.issue("move", x=0.0, y=0.4), 60).state == "completed"
