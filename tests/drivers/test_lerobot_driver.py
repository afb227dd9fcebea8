"""LeRobot's own SO-101 class, bus and SDK, on a pty, against six simulated servos.

In real time: the SDK waits a few milliseconds for a packet, and asks only once where it connects.
"""

import subprocess
import threading
from importlib.util import find_spec

import pytest

from robots.kit.contract.find import spec_of
from tests.conftest import wait_for
from tests.rig import PYTHON, ROOT, Simulator

pytestmark = pytest.mark.timed

INSTALLED = find_spec("lerobot") is not None
needs = pytest.mark.skipif(not INSTALLED, reason="LeRobot is an optional extra: make test-lerobot")
DEGREE = 4095 / 360  # ticks, as LeRobot counts


class Servos(Simulator):
    """The six servos as a process."""

    def start(self):
        (self.folder / "tty").unlink(missing_ok=True)
        self.process = subprocess.Popen([PYTHON, "-m", "simulators.so101", "--dir", str(self.folder)], cwd=ROOT)
        wait_for((self.folder / "tty").exists, 30, "the servos")

    def degrees(self):
        return [(t - 2047.5) / DEGREE for t in self.status()["ticks"]]


@pytest.fixture
def servos(tmp_path):
    made = Servos(tmp_path)
    yield made
    made.stop()


@pytest.fixture
def arm(servos):
    made = driver(servos)
    made.connect()
    yield made
    made.close()


def driver(servos, **settings):
    from robots.kit.drivers.so101.driver import Driver

    return Driver(str(servos.folder / "tty"), settings)


def allow():
    """Permit everything."""


def do(arm, kind, permit=allow, **args):
    stages = []
    outcome = arm.execute(kind, args, permit, stages.append)
    assert stages == ["sent", "acknowledged"]
    return outcome


def goals(servos):
    return [r["goals"] for r in servos.journal() if r["event"] == "goal"]


def test_controls_come_from_the_description_without_the_library():
    features = spec_of("so101")
    assert features.joints == ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")
    pan = features.command("move").arguments[0]
    assert (pan.name, pan.unit, pan.required) == ("shoulder_pan", "rad", False)
    assert (pan.low, pan.high) == pytest.approx((-1.5708, 1.5708), abs=1e-4)
    assert features.command("move").arguments[-1].high == 1.0


@needs
def test_it_goes_where_it_is_told_and_says_what_was_sent(arm, servos):
    outcome = do(arm, "move", shoulder_pan=0.5, gripper=0.6)
    assert outcome.sent["shoulder_pan"] == pytest.approx(0.5, abs=1e-5)
    assert outcome.state.joints[0] == pytest.approx(0.5, abs=0.01)
    assert servos.degrees()[0] == pytest.approx(28.6, abs=0.5)
    assert servos.degrees()[1] == pytest.approx(0.0, abs=0.5), "what is left out stays"
    assert (servos.status()["ticks"][5] - 700) / 2695 == pytest.approx(0.6, abs=0.01)
    steps = [b[0] - a[0] for a, b in zip(goals(servos), goals(servos)[1:], strict=False)]
    assert max(steps) <= 45 * DEGREE / 30 + 2, "no goal is farther than the speed allows"


@needs
def test_what_lerobot_clips_is_told(servos, monkeypatch):
    from robots.kit.description import load

    monkeypatch.setitem(load("so101")["lerobot"]["options"], "max_relative_target", 0.8)  # degrees a goal
    arm = driver(servos)
    arm.connect()
    outcome = do(arm, "move", shoulder_pan=1.0)
    assert outcome.sent["shoulder_pan"] < 0.9
    assert outcome.state.joints[0] == pytest.approx(outcome.sent["shoulder_pan"], abs=0.05)
    arm.close()


@needs
def test_a_hold_ends_a_motion_on_its_way_and_no_goal_of_before_follows(arm, servos):
    from robots.kit.contract.errors import MotionHeld

    errors = []

    def go():
        try:
            do(arm, "move", shoulder_pan=1.5)
        except MotionHeld as error:
            errors.append(error)

    thread = threading.Thread(target=go)
    thread.start()
    wait_for(lambda: servos.degrees()[0] > 10, 10, "it is on its way")
    state = arm.hold()
    there = goals(servos)
    thread.join(5)
    assert len(errors) == 1
    assert state.joints[0] < 1.2
    assert arm.state().ready, "the servos have read all that came before"
    assert goals(servos) == there
    wait_for(lambda: not servos.status()["moving"], 2, "rest")


@needs
def test_each_step_wants_a_permit(arm, servos):
    from robots.kit.contract.errors import Stopped

    before = len(goals(servos))

    def forbid():
        raise Stopped("The robot is stopped.")

    with pytest.raises(Stopped):
        arm.execute("move", {"shoulder_pan": 0.5}, forbid, lambda _: None)
    assert len(goals(servos)) == before
    left = iter(range(6))

    def a_while():
        if next(left, None) is None:
            raise Stopped("The robot is stopped.")

    with pytest.raises(Stopped):
        arm.execute("move", {"shoulder_pan": 0.5}, a_while, lambda _: None)
    assert 0 < len(goals(servos)) - before <= 6


@needs
def test_bad_values_are_named(arm, servos):
    from robots.kit.contract.errors import BadRequest

    for args, words in (({"shoulder_pan": 9}, "must lie between"), ({"knee": 1}, "no value called knee")):
        with pytest.raises(BadRequest, match=words):
            arm.execute("move", args, allow, lambda _: None)
    assert goals(servos) == []


@needs
def test_a_noisy_line_is_asked_again_and_a_silent_one_is_named(arm, servos):
    from robots.kit.contract.errors import LineSilent

    servos.fault("corrupt", 0.02, seed=3)
    do(arm, "move", elbow_flex=0.3)
    assert servos.degrees()[2] == pytest.approx(17.2, abs=0.6)
    servos.clear()
    servos.fault("mute")
    with pytest.raises(LineSilent, match="does not answer"):
        arm.state()
    servos.clear()
    assert arm.recover(allow).ready


@needs
def test_a_pulled_cable_is_named_and_mended(arm, servos):
    from robots.kit.contract.errors import HardwareFault

    servos.stop()
    with pytest.raises(HardwareFault):
        arm.state()
    servos.start()
    assert arm.recover(allow).ready
    do(arm, "ready")
    assert servos.degrees()[1] == pytest.approx(-60, abs=0.6)


@needs
def test_a_robot_that_was_never_calibrated_is_refused_in_words(servos):
    from robots.kit.contract.errors import HardwareFault

    kept = servos.folder / "calibration" / "farhand.json"
    kept.write_text(kept.read_text().replace("3395", "3000"))
    with pytest.raises(HardwareFault, match="lerobot-calibrate .*--robot.id=farhand"):
        driver(servos).connect()


@needs
def test_it_is_driven_and_stopped_through_the_worker(transactional_db, redis_server, people):
    from portal.keep.seeding import add_robot
    from portal.run.processes import robot_processes
    from robots import bus, services
    from robots.kit.clock import SYSTEM
    from robots.models import Command, Lease, Robot
    from robots.states import Cycle, GrantKind
    from tests.rig import Child

    bus.connection().flushall()
    robot = add_robot("so101")
    children = [Child(p.name.replace(" ", "-"), list(p.argv), **p.env) for p in robot_processes(robot)]
    try:
        wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 60, "the robot is in order")
        services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
        Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.OPERATING)

        def ended(command):
            command.refresh_from_db()
            return command.final

        first = services.issue(robot.slug, people["ada"], "move", {"shoulder_pan": 0.4}, 1).command
        wait_for(lambda: ended(first), 20, "the move")
        assert (first.state, first.result["sent"]["shoulder_pan"]) == ("completed", pytest.approx(0.4, abs=1e-4))
        assert Lease.objects.get(robot=robot).state["joints"][0] == pytest.approx(0.4, abs=0.02)
        far = services.issue(robot.slug, people["ada"], "move", {"wrist_roll": 2.5}, 2).command
        wait_for(lambda: Command.objects.get(pk=far.pk).state == "acknowledged", 10, "it moves")
        services.stop(robot, people["ada"])
        wait_for(lambda: ended(far), 10, "the stop")
        assert far.state == "cancelled"
    finally:
        for child in children[::-1]:
            child.kill()


def test_without_the_library_it_is_named_in_words():
    code = "import sys\nsys.modules['lerobot'] = None\nfrom robots.kit.contract.find import open_session\n"
    code += "open_session('so101', '/dev/null', {})"
    done = subprocess.run([PYTHON, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert "LeRobot, or a part of it that this robot needs, is not installed" in done.stderr
