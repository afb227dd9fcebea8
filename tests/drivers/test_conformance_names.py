"""The conformance suite names what is wrong with a driver: a sound driver is broken in one way after another."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from threading import Thread

import pytest

from robots.kit.conformance.report import Verdict
from robots.kit.conformance.suite import conform
from robots.kit.conformance.trial import Limits, children
from robots.kit.contract.channels import IN_PLANE
from robots.kit.contract.policies import Bound, Policies
from tests.drivers import broken_rails as broken
from tests.drivers.rail import CAMERA, CLOCK, SPEC, Cart, Rail

PATIENT = Limits(answer_s=600.0, watch_s=1.0, beyond_s=600.0)  # of a clock that runs ten times faster
HASTY = Limits(answer_s=10.0, watch_s=1.0, beyond_s=5.0)  # for what never ends


def tried(driver, *only, spec=SPEC, limits=PATIENT):
    cart = Cart()
    return conform(
        lambda: driver(cart, {}), spec, CLOCK, limits=limits, description=CAMERA, faults=lambda: cart, only=only,
        nowhere=lambda: driver("nowhere", {}),
    )  # fmt: skip


def test_a_driver_that_is_in_order_passes_every_check_that_applies():
    report = tried(Rail)
    assert not report.failures, report.text()
    assert {r.check for r in report.results if r.verdict == Verdict.NOT_APPLICABLE} == set(), report.text()
    assert "22 passed, 0 failed" in report.text()


BROKEN = [
    (broken.TakesAnything, "values", "execute takes go(x=nan); refuse it with BadRequest"),
    (broken.Complains, "values", "by ValueError"),
    (broken.AsksTooLate, "permit", "although permit() had raised; call permit() before the actuation"),
    (broken.SwallowsTheNo, "permit", "execute answered HardwareFault (It did not work.); let it through as it is"),
    (broken.StagesReversed, "commands", "told the stages ['acknowledged', 'sent']"),
    (broken.ReturnsNothing, "commands", "execute returned NoneType"),
    (broken.EndsEarly, "commands", "The robot moves after go("),
    (broken.StopsShort, "commands", ", the robot shows "),
    (broken.FailsWithoutWords, "commands", "ended with KeyError"),
    (broken.IgnoresHold, "hold", "returned a state that moves"),
    (broken.LiesOnHold, "hold", "The robot moves on after hold()"),
    (broken.ForgetsTheHold, "hold", "returned as if nothing had happened"),
    (broken.HoldsForEver, "hold", "A motion after a hold ended with HardwareFault (The cart is held.)"),
    (broken.OnAnotherClock, "state", "stamp it by self.clock.monotonic()"),
    (broken.TellsMore, "state", "tells the channel 'mood', which the spec does not declare"),
    (broken.TellsLess, "state", "does not tell the channel 'pace'"),
    (broken.TellsNoNumber, "state", ") state() tells nan for 'cart'"),
    (broken.TellsTooManyJoints, "state", "tells 2 joints; the spec declares 1"),
    (broken.TellsATwistWithoutAPose, "state", "tells a twist of 3 numbers for a pose of 0"),
    (broken.OffTheRail, "state", "for the joint 'cart', which its scale says lies in"),
    (broken.KeepsNothing, "state", "latest() returns nothing"),
    (broken.TellsNoState, "connect", "connect() returned NoneType instead of a RobotState"),
    (broken.IsEverywhere, "connect", "connect() to an address where nothing is answers no error"),
    (broken.CloseRaises, "end", "close() a second time raised LineGone"),
    (broken.BeginsWithADelta, "streams", "begins with a delta"),
    (broken.NeverAKeyAgain, "streams", "sends no key packet although stream() returned True"),
    (broken.TooLong, "streams", "has 1048577 bytes; send at most 1048576"),
    (broken.AnotherStream, "streams", "It sends the stream 'map'"),
    (broken.RecoversUnasked, "recovery", "recover() never called permit()"),
    (broken.RecoversTooEarly, "recovery", "The robot moved in recover() although permit() had raised"),
    (broken.JogsOn, "held motions", "does not call permit() while it moves"),
    (broken.CannotBeReplaced, "replaced", "did not call permit() on its way"),
    (broken.LostWithoutWords, "lost line", "execute ended with OSError"),
    (broken.BelievesNoise, "noise", "Under the fault 'corrupt' state() tells inf for 'cart'"),
    (broken.AsksOnce, "steered", "does not call steered() while it moves"),
    (broken.GoesOnPastItsTime, "time left", "may move for 2.5 s more, and without a word the robot would rest within"),
    (broken.SaysMoreThanItsSpec, "rests within", "rests_within() says 1000.0 s in go("),
    (broken.NeverAtRest, "rests within", "rests_within() says 5.0 of a robot at rest"),
    (broken.AsksTheWire, "rests within", "answers LineGone (The cart does not answer.) on a silent line"),
    (broken.AnotherShape, "pictures", "gave a picture of 32 x 9 px; robot.toml says 32 x 8"),
    (broken.NoPicture, "pictures", "6 bytes that are no JPEG or PNG"),
]
WAITS_FOR_EVER = [
    (broken.Mute, "commands", "told no stage"),
    (broken.LeavesAThread, "end", "these threads are left: watcher of the rail"),
    (broken.NeverAsks, "permit", "execute never called permit() for go(x="),
    (broken.LockedHold, "hold", 'hold() while on_stage("sent") is told did not return'),
    (broken.PaceWaits, "lanes", "waits for the motion that runs"),
    (broken.NotShown, "lanes", "The channel 'pace' does not show"),
    (broken.GoesOnWithoutALine, "close in motion", "execute did not end after close()"),
    (broken.IgnoresTheStick, "steered", "goes on as it began after newer values had come (jog(way="),
    (broken.NeverRests, "rests within", "and it still moves long after the"),
    (broken.CloseWaits, "close in motion", "close() under a motion did not return"),
]


def named(driver, check, words, limits):
    before = ("commands",) if check in ("state", "streams") else ()  # what they judge is seen there
    report = tried(driver, *before, check, limits=limits)
    assert report.of(check).verdict == Verdict.FAILED, report.text()
    assert any(words in said for said in report.of(check).words), report.text()


@pytest.mark.parametrize(("driver", "check", "words"), BROKEN, ids=lambda value: getattr(value, "__name__", ""))
def test_what_is_broken_is_named(driver, check, words):
    named(driver, check, words, PATIENT)


@pytest.mark.timed
@pytest.mark.parametrize(("driver", "check", "words"), WAITS_FOR_EVER, ids=lambda value: getattr(value, "__name__", ""))
def test_what_waits_for_ever_is_named(driver, check, words):
    named(driver, check, words, HASTY)


def test_a_policy_that_nothing_can_judge_is_named():
    """A bound of seconds alone, and those of a speed and of a turn that no state tells."""

    class NoVelocities(Rail):
        def told(self, x, moving):
            return replace(super().told(x, moving), velocities=())

    go, *others = SPEC.commands
    for bound, driver, words in (
        (Bound(5.0), Rail, "bounds neither place nor speed"),
        (Bound(5.0, speed=1.0), NoVelocities, "its states tell no velocities"),
        (Bound(5.0, turn=1.0), Rail, "its states tell no twist"),
    ):
        pose = IN_PLANE if bound.turn is not None else None
        spec = replace(SPEC, pose=pose, commands=(replace(go, policies=Policies(on_link_lost=bound)), *others))
        assert words in " ".join(tried(driver, "commands", "policies", spec=spec).of("policies").words)


def test_processes_are_counted_while_threads_begin_and_end():
    def briefly(_):
        for _ in range(300):
            thread = Thread(target=int)
            thread.start()
            thread.join()

    with (
        subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as child,
        ThreadPoolExecutor(4) as threads,
    ):
        ended = [threads.submit(briefly, n) for n in range(4)]
        counted = [children()]
        while not all(one.done() for one in ended):
            counted.append(children())
        child.communicate(b"\n")
    assert all(child.pid in one for one in counted)
    assert child.pid not in children()
