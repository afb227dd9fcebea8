"""Promises 1 to 12 where a motion is a velocity that the owner renews: exploring, charging, driving by hand."""

import math
import random
import signal
import time

import pytest
from celery import current_app

from queueing import services as queue
from queueing.services import resume
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.contract.capabilities import Stills
from robots.kit.contract.errors import BadRequest, RobotError, Stopped
from robots.kit.contract.procedures import PICTURE
from robots.kit.contract.values import check
from robots.kit.description import load
from robots.kit.drivers.irat.protocol import Velocity
from robots.models import Command, Grant, Robot
from robots.states import COMMAND_FINAL, COMMAND_RUNNING, CommandState, GrantEnd
from tests.conftest import wait_for
from tests.drivers.irat_wire import WireClient
from tests.faults.test_promises_stop import held_after, percentile, release, rested
from tests.faults.test_promises_wire import WILD
from tests.faults.witness import STALLED
from tests.looked import heard

# ruff: noqa: TID251 - its tests are timed
pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["irat"], indirect=True)]
HAND = load("irat")["hand"]
FORGOTTEN_S = 0.5  # a velocity is forgotten after 0.25 s; then the robot brakes


@pytest.fixture(autouse=True)
def strangers_leave():
    yield
    while WireClient.OPEN:
        WireClient.OPEN.pop().close()


def roam(rig, kind="explore"):
    """Begin a motion that the robot renews by itself; return its command once the wheels turn."""
    command = rig.issue(kind)
    rig.moving()
    time.sleep(0.5)
    rig.moving()  # it may have come to a wall, and turns
    return command


def stays_at_rest(rig):
    """Judge that nothing moves it once its owner, which alone sends velocities, runs nothing and has nothing to run."""
    wait_for(lambda: not rig.sim.status()["moving"], 3, "rest")
    before = rig.sim.count("motion")
    rig.swept()
    assert rig.sim.count("motion") == before, "something moved it"
    assert max(map(abs, rig.sim.status()["reference"])) == 0.0


def tick(times):
    """Let the queue do what is due."""
    for _ in range(times):
        queue.tick(SYSTEM.now())
        time.sleep(0.1)


def works(rig):
    """Wait until the robot is well and drives by hand again."""
    wait_for(lambda: not rig.reason() and rig.final(rig.issue("up"), 60).state == "completed", 90, "work goes on")


def test_promise_01_a_motion_that_has_ended_is_never_taken_up_again(rig, proof):
    """Announced, queued and asked for again and again, during the motion and after it, among rogue workers."""
    rig.owner()
    rig.start_worker()
    rig.grant(seconds=3000)
    times = proof.count("motions that renew themselves, each delivered 10 times", 2, 10)
    epoch = rig.lease().epoch

    def deliver(command):
        for _ in range(5):
            bus.connection().publish(bus.wake_channel(rig.robot.slug), b"wake")
            for which in (epoch, epoch - 1, epoch + 1):
                current_app.send_task(bus.WAKE_TASK, queue=bus.queue_name(rig.robot.slug, which), ignore_result=True)
            assert rig.issue("explore", seq=command.client_seq).pk == command.pk

    for i in range(times):
        command = roam(rig)
        deliver(command)
        services.stop(rig.robot, rig.people["ada"]) if i % 2 else rig.sim.fault("power_cycle", count=1)
        rig.final(command, 60)
        deliver(command)
        stays_at_rest(rig)
        if i % 2:
            release(rig)
        assert command.state in ("cancelled", "failed"), command.state
        works(rig)
    assert Command.objects.filter(kind="explore").count() == times
    proof.holds(f"{times} motions delivered {10 * times} times more: none began a second time")


def test_promise_02_a_death_rests_the_wheels_and_nothing_is_repeated(rig, proof, witness):
    """The owner and its brain are killed while the robot explores, charges and drives by hand."""
    times = proof.count("deaths", 3, 30)
    worst = 0.0
    rig.owner()
    rig.grant(seconds=3000)
    rig.share = 0.1
    for i in range(times):
        kind = ("explore", "charge", "move")[i % 3]
        command = roam(rig, kind) if kind != "move" else rig.issue("move", x=0.1, y=0.4)
        rig.moving()
        at, epoch = time.monotonic(), rig.lease().epoch
        rig.workers[-1].kill()
        worst = max(worst, rested(rig, witness, at))
        second = rig.start_worker()
        command = rig.final(command, 60)
        assert command.state == "unknown", (kind, command.state, command.reason)
        assert "not known" in command.reason
        wait_for(lambda epoch=epoch: rig.lease().epoch > epoch, 40, "the next owner")
        stays_at_rest(rig)
        assert not Command.objects.filter(state__in=COMMAND_RUNNING).exists()
        assert second.alive()
        works(rig)
    assert worst <= FORGOTTEN_S, worst
    proof.holds(f"{times} deaths in motion: at rest within {worst * 1000:.0f} ms, 0 motions repeated")


def test_promise_03_a_velocity_that_comes_late_moves_nothing(rig, line, proof, witness):
    """The network stalls, then delivers everything that was sent meanwhile."""
    times = proof.count("stalls of 1 to 3 s", 2, 20)
    rig.grant(seconds=3000)
    for i in range(times):
        rig.share = 0.2
        command = roam(rig) if i % 2 else rig.issue("move", x=0.1, y=0.4)
        rig.moving()
        at = time.monotonic()
        line.set("stall")
        assert rested(rig, witness, at) <= FORGOTTEN_S
        before = rig.sim.count("motion")
        time.sleep(1.0 + i % 3)
        services.stop(rig.robot, rig.people["ada"])
        time.sleep(0.2)
        line.set("pass")
        # the hold went the same way, after them
        wait_for(lambda: Robot.objects.get().stop_confirmed, 20, "the robot has heard of the stop")
        assert rig.sim.count("motion") == before, "what was sent before the stop moved it after the stall"
        assert rig.sim.count("late"), "velocities came late, and were refused"
        assert rig.final(command, 30).reason
        release(rig)
        rig.share = None
        works(rig)
    proof.holds(f"{times} stalls: at rest within {FORGOTTEN_S * 1000:.0f} ms each, 0 motions by what came late")


def test_promise_04_a_newer_commander_replaces_the_owner_which_says_so(rig, proof, witness):
    """Another portal claims the robot: it is braked, the owner's velocities move nothing, and its page names the cause."""
    times = proof.count("other commanders", 2, 20)
    rig.start_worker()
    rig.wait_ready()
    rig.grant(seconds=3000)
    for i in range(times):
        rig.share = 0.05
        command = roam(rig) if i % 2 else rig.issue("move", x=0.1, y=0.4)
        rig.moving()
        other, at = WireClient(rig.sim), time.monotonic()
        epoch = rig.lease().epoch + 1000 * (i + 1)
        assert other.claim(epoch)["success"]
        assert rested(rig, witness, at) <= FORGOTTEN_S
        stays_at_rest(rig)
        command = rig.final(command, 15)
        assert command.state in ("failed", "cancelled"), (command.state, command.reason)
        wait_for(lambda: "another" in rig.reason(), 15, "the page names the other")
        stays_at_rest(rig)
        other.close()
        rig.sim.power_cycle()  # it forgets who commanded, as it does by itself after a minute without a commander
        rig.share = None
        works(rig)
    proof.holds(f"{times} newer commanders: braked, 0 motions of the owner after, named on the page")


def test_promise_06_what_staff_hold_rests_when_their_controls_or_the_owner_are_lost(rig, proof, witness):
    times = proof.count("losses", 3, 50)
    rig.owner()
    rig.grant(seconds=3000)
    worst = 0.0
    for i in range(times):
        rig.share = 0.1
        command = rig.issue("move", x=0.25, y=0.5)
        rig.moving()
        time.sleep(0.2)
        at = time.monotonic()
        if i % 3 == 0:
            rig.controls.lose()
        elif i % 3 == 1:
            rig.workers[0].signal(signal.SIGSTOP)
        else:
            services.end_grant(services.open_grant(rig.robot), GrantEnd.STAFF, "over", SYSTEM.now())
        seconds = rested(rig, witness, at)
        worst = max(worst, seconds) if i % 3 < 2 else worst  # the row is the judge of a grant, asked each second
        if i % 3 == 1:
            rig.workers[0].signal(signal.SIGCONT)
        assert rig.final(command, 20).state in ("cancelled", "completed")
        stays_at_rest(rig)
        rig.controls.find()
        rig.share = None
        if services.open_grant(rig.robot) is None:
            rig.grant(seconds=3000)
        works(rig)
    assert worst <= 0.5, worst
    proof.holds(f"{times} losses of controls, owner and grant: at rest within {worst * 1000:.0f} ms")


@pytest.mark.parametrize("kind", ["explore", "charge"])
def test_promise_07_stop_overtakes_a_motion_that_renews_itself(rig, proof, witness, kind):
    times = proof.count(f"stops, {kind}", 4, 50)
    rig.owner()
    took = []
    for _ in range(times):
        if services.open_grant(rig.robot) is None:
            rig.grant(seconds=3000)
        command = roam(rig, kind)
        at = time.monotonic()
        assert bus.send_stop(rig.robot.slug)
        seconds = held_after(rig, at)
        if witness.clean(at, at + seconds):
            took.append(seconds)
        assert rig.final(command, 10).state == "cancelled"
        release(rig)
    assert len(took) >= times / 2, f"measurements: not within {times} attempts, because the machine stalled too often"
    assert percentile(took, 0.99) <= 0.300, took
    proof.discards(witness.discarded, STALLED)
    proof.holds(f"{kind}: 99 % of {len(took)} stops at rest within {percentile(took, 0.99) * 1000:.0f} ms")


def test_promise_08_a_stopped_robot_takes_up_nothing_by_itself(rig, proof):
    """Neither its idle hours nor a need, a job, staff or a new owner move it; after the release it rests, too."""
    proof.count("stops", 1, 1)
    rig.owner()
    rig.grant(seconds=3000)
    command = roam(rig)
    services.stop(rig.robot, rig.people["ada"])
    wait_for(lambda: not rig.sim.status()["moving"], 3, "the hold")
    assert rig.final(command, 10).state == "cancelled"
    wait_for(lambda: Robot.objects.get().stop_latched, 10, "the row")
    for kind in ("explore", "charge", "move"):
        with pytest.raises(Stopped):
            rig.issue(kind, **({"x": 0.1, "y": 0.4} if kind == "move" else {}))
    services.end_grant(services.open_grant(rig.robot), GrantEnd.STAFF, "over", SYSTEM.now())
    rig.sim.fault("charge", 0.15)  # it needs to charge
    before = rig.sim.count("motion")
    tick(20)
    handed_over = Grant.objects.filter(kind="handover").exclude(ended_at=None)
    times = handed_over.count()
    rig.workers[0].kill()
    rig.start_worker()
    wait_for(lambda: handed_over.count() > times, 60, "the next owner")
    tick(20)
    assert not Command.objects.exclude(state__in=COMMAND_FINAL).exists()
    assert Command.objects.filter(created_at__gt=command.ended_at, kind__in=("explore", "charge")).count() == 0
    assert rig.sim.count("motion") == before
    release(rig)
    tick(20)
    assert rig.sim.count("motion") == before, "staff have released the stop, but not resumed"
    resume(rig.robot, rig.people["kim"], SYSTEM.now())

    def charges():
        tick(1)
        return Command.objects.filter(kind="charge").exists()

    wait_for(charges, 30, "the need is met once staff have resumed")
    proof.holds("60 ticks of the queue, a need, a new owner and the release after the stop: 0 motions, 0 commands")


def test_promise_09_no_velocity_outside_the_bounds_is_taken(rig, proof):
    """The web process, the owner and the robot each refuse by themselves."""
    dice, number = random.Random(9), proof.count("generated commands", 3000, 100_000)
    kinds = {
        "drive": ("forward", "turn"), "goal": ("map", "x", "y", "experience"), "explore": (), "charge": (),
        "pruning": ("on",), "fly": ("x",), "clear_map": (),
    }  # fmt: skip
    through = 0
    for _ in range(number):
        kind = dice.choice(("drive", *kinds))
        wild = {n: dice.choice(WILD) if dice.random() < 0.3 else dice.uniform(-1.4, 1.4) for n in kinds[kind]}
        args = {n: v for n, v in wild.items() if dice.random() < 0.97}
        try:
            check("irat", kind, args, {})
        except RobotError as error:
            assert str(error)
            continue
        through += 1
        if kind == "drive":
            v, w = args["forward"] * HAND["speed"], args["turn"] * HAND["turn"]
            assert math.isfinite(v + w) and abs(v) <= HAND["speed"] and abs(w) <= HAND["turn"]
            Velocity.decode(Velocity(v, w).encode())
    assert through > number / 50
    rig.owner()
    grant, before = rig.grant(seconds=3000), rig.sim.count("motion")
    wrong = [{"forward": v, "turn": 0.5} for v in (1.001, -2, 1e308, "1", None, True, [1], {})] + [{}, {"forward": 1}]
    for i, args in enumerate(wrong):
        with pytest.raises(BadRequest):
            rig.issue("drive", **args)
        now = SYSTEM.now()
        unchecked = Command.objects.create(
            robot=rig.robot, grant=grant, client_seq=1000 + i, issued_by=rig.people["ada"], kind="drive", args=args,
            epoch=rig.lease().epoch, created_at=now, deadline=now + services.commands.timedelta(seconds=10), limit_s=60,
        )  # fmt: skip
        bus.send_keep_alive(rig.robot.slug, unchecked.pk, True)
        bus.wake_owner(rig.robot.slug, unchecked.epoch)
        assert rig.final(unchecked, 15).state == CommandState.REJECTED, unchecked.reason
    assert rig.sim.count("motion") == before
    assert rig.sim.count("passed") == 0
    proof.holds(
        f"{number} commands, {through} let through, 0 outside; {len(wrong)} rows that nobody checked: 0 motions"
    )


@pytest.fixture
def line(rig):
    return rig.line_proxy()


@pytest.mark.parametrize("how", ["cut", "reset", "stall", "half", "spoil"])
def test_promise_10_a_broken_line_causes_no_wrong_move(rig, line, proof, witness, how):
    """In mid-motion: at rest at once, the command ends in words, nothing is repeated, work goes on by itself."""
    times = proof.count(f"times, {how}", 2, 20)
    rig.grant(seconds=3000)
    worst = 0.0
    for i in range(times):
        rig.share = 0.05
        command = roam(rig) if i % 2 else rig.issue("move", x=0.1, y=0.4)
        rig.moving()
        at = time.monotonic()
        line.set(how)
        if how in ("cut", "reset", "stall"):
            worst = max(worst, rested(rig, witness, at))
        command = rig.final(command, 70)
        assert command.state in ("failed", "unknown", "cancelled", "completed"), command.state
        assert command.state == "completed" or command.reason.endswith("."), command.reason
        wait_for(lambda: not rig.sim.status()["moving"], 10, "rest")
        before = rig.sim.count("motion")
        line.set("pass")
        heard(rig, seconds=60)  # a held motion that is over before it begins: the robot answers its hold
        assert rig.sim.count("motion") == before, "something moved it when the line was back"
        rig.share = None
        works(rig)
        assert rig.sim.count("passed") == rig.sim.count("crash") == 0
        assert rig.workers[-1].alive()
    assert worst <= FORGOTTEN_S, worst
    rest = f", at rest within {worst * 1000:.0f} ms" if worst else ""
    proof.holds(f"{how}: {times} times in mid-motion{rest}, 0 wrong moves")


def test_promise_12_a_picture_is_always_answered(rig, proof):
    a_picture_is_always_answered(rig, proof)


def a_picture_is_always_answered(rig, proof):
    """This robot declares no stability check, and no command of it ends with a still; staff may ask for a picture."""
    spec = rig.robot.spec()
    assert spec.capability(Stills) is None and not any(c.still_after for c in spec.commands)
    times = proof.count("answers a fault", 1, 20)
    rig.owner()
    rig.grant(seconds=3000)
    slowest, said = 0.0, {}
    for verb in ("cam_freeze", "cam_black", "cam_flicker", "cam_gone", "cam_slow"):
        for _ in range(times):
            rig.sim.fault(verb, 5.0 if verb == "cam_slow" else 1.0)
            begun = time.monotonic()
            picture = rig.final(rig.issue(PICTURE.kind), 60)
            slowest = max(slowest, time.monotonic() - begun)
            said[verb] = picture.result["verdict"]
            assert said[verb] == ("no picture" if verb in ("cam_gone", "cam_slow") else "not judged"), verb
            assert not picture.result.get("stable"), "nobody has judged it"
            driven = rig.done("up")
            silent = verb in rig.wishes.silent_meanwhile and driven.reason
            assert driven.state == "completed" or silent, f"{verb} undoes a motion by hand: {driven.reason}"
            assert "verdict" not in driven.result
            rig.sim.clear()
            wait_for(lambda: rig.final(rig.issue(PICTURE.kind), 60).result.get("still"), 60, "a picture")
    assert slowest < 30
    proof.holds(f"{5 * times} answers, slowest {slowest:.1f} s; said {said}")
