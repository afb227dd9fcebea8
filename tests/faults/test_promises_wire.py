"""Promises 9, 10 and 12: the envelope, the noisy line, and a check of stability that always answers."""

import math
import random
import time

import pytest

from robots.kit.contract.errors import RobotError
from robots.kit.contract.session import RobotState
from robots.kit.contract.values import check
from robots.kit.description import load
from robots.kit.drivers.mercury.scara import scara
from robots.models import Incident, Robot
from tests.conftest import EACH_AT_LENGTH, at_length, wait_for

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

WILD = (math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 0, True, None, "0.1", [0.1], {"x": 1}, 2**63, -0.0)


def test_promise_09_nothing_outside_the_envelope_gets_through(proof):
    """The server's check and the driver's are the same code at two places; both are asked."""
    dice = random.Random(9)
    number = proof.count("generated commands", 3000, 100_000)
    description = load("mercury")
    arm, sand = scara(description), description["sand"]
    through = outside = 0

    def value():
        return dice.choice(WILD) if dice.random() < 0.3 else dice.uniform(-0.8, 0.8)

    for _ in range(number):
        kind = dice.choice(("move", "move", "move", "jog", "air", "speed", "up", "fly"))
        names = {"move": ("x", "y"), "jog": ("dx", "dy"), "air": ("seconds",), "speed": ("speed",)}.get(kind, ("x",))
        args = {name: value() for name in names if dice.random() < 0.97}
        pose = (0.0, 0.4, dice.choice((0.0, 0.075)), 0.0)
        try:
            check("mercury", kind, args, {}, RobotState(0.0, (), pose, False, True))
        except RobotError as error:
            assert str(error)
            continue
        through += 1
        if kind == "move":
            x, y = args["x"], args["y"]
            inside = sand["x"][0] - 1e-5 <= x <= sand["x"][1] + 1e-5 and sand["y"][0] - 1e-5 <= y <= sand["y"][1] + 1e-5
            outside += not (inside and arm.inner_radius <= math.hypot(x, y) <= arm.outer_radius)
        elif kind == "jog":
            outside += not all(-1 <= args[n] <= 1 for n in names)
        elif kind in ("air", "speed"):
            low, high = (0.05, 0.5) if kind == "air" else description["motion"]["speed_range"]
            outside += not all(low <= v <= high for v in args.values())
    assert through > number / 50
    assert outside == 0
    proof.holds(f"{number} commands, {through} let through, 0 outside")


@pytest.mark.parametrize("verb", ["corrupt", "double_ack", *map(at_length, ("drop", "double", "slow"))])
def test_promise_10_line_noise_cannot_cause_a_wrong_move(rig, proof, verb):
    """10 % of the bytes spoilt: each motion goes where a command said, or none is made."""
    number = proof.count(f"moves, {verb}", 2, 12, 100)
    rig.owner()
    rig.grant(seconds=3000)
    rig.sim.forget()  # on the way to its home it went where the handover began
    dice = random.Random(10)
    home = load("mercury")["home"]
    wanted = {(home["x"], home["y"])}
    ends = {}
    worst = 0
    for i in range(number):
        x, y = round(dice.uniform(-0.2, 0.2), 3), round(dice.uniform(0.3, 0.5), 3)
        wanted.add((x, y))
        wait_for(lambda: not Robot.objects.get().reason, 90, "the robot is well")
        rig.sim.fault(verb, {"double_ack": 1.0, "slow": 0.4}.get(verb, 0.03 if i % 2 else 0.1), seed=i + 1)
        command = rig.final(rig.issue("move", x=x, y=y), 90)
        rig.sim.clear()
        ends[command.state] = ends.get(command.state, 0) + 1
        if command.state == "completed":
            pose = rig.sim.status()["pose"]
            assert math.hypot(pose[0] - x, pose[1] - y) < 0.001
        elif command.state == "failed":
            kept = Incident.objects.filter(command=command)
            wait_for(kept.exists, 10, "the incident of the fault")
            worst += 1
    made = [tuple(round(v, 3) for v in r["target"][:2]) for r in rig.sim.journal() if r["event"] == "motion"]
    wrong = [m for m in made if not any(math.dist(m, w) < 0.0015 for w in wanted)]
    if wrong:
        for r in rig.sim.journal():
            print(r)
        from robots.models import Command as C

        for c in C.objects.all():
            print(c.pk, c.kind, c.args, c.state, c.reason, c.result)
    assert wrong == []
    wait_for(lambda: not Robot.objects.get().reason, 90, "recovered without a shell")
    assert rig.final(rig.issue("move", x=0.0, y=0.4), 60).state == "completed"
    proof.holds(f"{verb} at 10 and 3 %: {len(made)} motions, 0 wrong; commands ended {ends}")


def test_promise_10_another_program_on_the_port_is_named(rig, proof):
    import serial

    proof.count("intruders", 1, 1)
    rig.own()
    with serial.Serial(str(rig.sim.folder / "tty"), 4800, exclusive=True):
        rig.start_worker()
        wait_for(lambda: "another program uses it" in rig.reason(), 30, "the page says so")
        assert rig.cycle() == "fault"
        assert rig.sim.count("motion") == 0
    rig.wait_ready(60)
    assert rig.reason() == ""
    proof.holds("named on the page, 0 motions meanwhile, ready again by itself when it had left")


def lose_the_line(rig, how):
    """Break the line in mid-motion; return what mends it."""
    rig.moving()
    time.sleep(0.2)
    if how == "cable pulled":
        rig.sim.process.kill()
        rig.sim.process.wait()
        wait_for(lambda: any(word in rig.reason() for word in rig.wishes.cut), 15, "the page names the cable")
        return rig.sim.start
    if how == "power lost":
        rig.sim.fault(rig.wishes.restart, count=1)
    if how == "never acknowledged":
        rig.sim.fault("mute")
    return rig.sim.clear


@EACH_AT_LENGTH
@pytest.mark.parametrize("how", ["cable pulled", *map(at_length, ("power lost", "never acknowledged"))])
def test_promise_10_a_line_that_is_lost_moves_nothing_twice(rig, proof, how):
    """In mid-motion: the command fails in words, no motion is repeated, work goes on without a shell."""
    times = proof.count(f"times, {how}", 1, 5, 20)
    rig.owner()
    rig.grant(seconds=3000)
    Robot.objects.update(settings={"speed": 0.1})
    rig.swept()
    made = []
    for i in range(times):
        rig.share = 0.1
        newest = Incident.objects.order_by("pk").values_list("pk", flat=True).last() or 0
        x = -0.21 + 0.01 * i
        if how == "never acknowledged" and rig.wishes.name == "mercury":
            rig.sim.fault("mute")  # the museum arm is asked for its state first, so its line falls silent on the way
        command = rig.issue("move", x=x, y=0.5)
        mend = lose_the_line(rig, how)
        made += motions(rig)
        command = rig.final(command, 60)
        assert command.state in ("failed", "unknown"), command.state
        assert command.reason.endswith(".")
        wait_for(Incident.objects.filter(pk__gt=newest).exists, 15, "the incident")
        mend()
        rig.share = None
        wait_for(lambda: rig.final(rig.issue("noop"), 60).state == "completed" and not rig.reason(), 60, "it is mended")
        back = rig.done("move", 60, x=0.2, y=0.31)
        assert back.state == "completed", back.reason
        made += motions(rig)
        goal = rig.wishes.goal(command)
        told = [m for m in dict.fromkeys(made) if len(m) > len(goal) and math.dist(m[1:], goal) < 0.0015]
        assert len(told) == 1, f"the motion that broke off was made {len(told)} times"
    proof.holds(f"{how}: {times} times in mid-motion, 0 motions repeated, each named and mended without a shell")


def motions(rig):
    """Return each motion that the simulator has noted: when, and where to."""
    return [(r["t"], *rig.wishes.made(r)) for r in rig.wishes.motions(rig.sim.journal())]
