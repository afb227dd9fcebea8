"""What is wrong with a driver is named by the conformance suite: one that is in order, broken in one way after another."""

import threading
from dataclasses import replace

import pytest

from robots.clock import SYSTEM
from robots.conformance.report import Verdict
from robots.conformance.suite import conform
from robots.conformance.trial import Limits
from robots.contract.channels import IN_PLANE
from robots.contract.errors import HardwareFault, LineGone
from robots.contract.policies import Bound, Policies
from robots.contract.session import Outcome, Progress, RobotState
from tests.drivers.rail import ALONE_S, CAMERA, CLOCK, REST_S, SPEC, Cart, Rail

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


class TakesAnything(Rail):
    def check(self, kind, args):
        pass


class Complains(Rail):
    def check(self, kind, args):
        try:
            super().check(kind, args)
        except Exception as error:
            raise ValueError(str(error)) from error


class NeverAsks(Rail):
    def execute(self, kind, args, permit, on_stage):
        return super().execute(kind, args, lambda: None, on_stage)


class AsksTooLate(Rail):
    def move(self, goal, free, on_stage):
        self.cart.go(goal)
        free()
        on_stage("sent")
        on_stage("acknowledged")


class SwallowsTheNo(Rail):
    def execute(self, kind, args, permit, on_stage):
        def ours():
            try:
                permit()
            except Exception as error:
                raise HardwareFault("It did not work.") from error

        return super().execute(kind, args, ours, on_stage)


class StagesReversed(Rail):
    def execute(self, kind, args, permit, on_stage):
        other = {"sent": "acknowledged", "acknowledged": "sent"}
        return super().execute(
            kind, args, permit, lambda stage: on_stage(stage if isinstance(stage, Progress) else other[stage])
        )


class Mute(Rail):
    def execute(self, kind, args, permit, on_stage):
        return super().execute(kind, args, permit, lambda stage: None)


class ReturnsNothing(Rail):
    def execute(self, *args):
        super().execute(*args)


class EndsEarly(Rail):
    def until_there(self, free, on_stage, alone=False):
        self.state()


class FailsWithoutWords(Rail):
    def until_there(self, free, on_stage, alone=False):
        raise KeyError("x")


class IgnoresHold(Rail):
    def hold(self):
        return self.state()


class LiesOnHold(Rail):
    def hold(self):
        self.holds += 1
        return replace(self.state(), moving=False)


class LockedHold(Rail):
    def __init__(self, *args):
        super().__init__(*args)
        self.lock = threading.RLock()

    def execute(self, *args):
        with self.lock:
            return super().execute(*args)

    def hold(self):
        with self.lock:
            return super().hold()


class ForgetsTheHold(Rail):
    def execute(self, kind, args, permit, on_stage):
        self.holds = 0
        try:
            return super().execute(kind, args, permit, on_stage)
        except Exception:
            if self.holds:
                return Outcome()
            raise


class HoldsForEver(Rail):
    def move(self, goal, free, on_stage):
        if self.holds:
            raise HardwareFault("The cart is held.")
        super().move(goal, free, on_stage)


class OnAnotherClock(Rail):
    def told(self, x, moving):
        return replace(super().told(x, moving), at=SYSTEM.now().timestamp())


class TellsMore(Rail):
    def told(self, x, moving):
        return replace(super().told(x, moving), values={"pace": 0.5, "mood": 1.0})


class TellsLess(Rail):
    def told(self, x, moving):
        return replace(super().told(x, moving), values={})


class TellsNoNumber(Rail):
    def told(self, x, moving):
        return replace(super().told(x, moving), joints=(float("nan") if moving else x,))


class TellsTooManyJoints(Rail):
    def told(self, x, moving):
        return replace(super().told(x, moving), joints=(x, x))


class TellsATwistWithoutAPose(Rail):
    def told(self, x, moving):
        return replace(super().told(x, moving), twist=(0.1, 0.0, 0.0))


class OffTheRail(Rail):
    def told(self, x, moving):
        return replace(super().told(x, moving), joints=(x + 5.0,))


class KeepsNothing(Rail):
    def keep(self, state):
        return state


class TellsNoState(Rail):
    def connect(self):
        super().connect()


class IsEverywhere(Rail):
    def connect(self):
        self.open = True
        return self.state() if isinstance(self.cart, Cart) else RobotState(0.0, (0.0,), (), False, True)


class CloseRaises(Rail):
    def close(self):
        if not self.open:
            raise LineGone("It was closed before.")
        super().close()


class LeavesAThread(Rail):
    def connect(self):
        self.stop = threading.Event()
        threading.Thread(target=self.stop.wait, args=(60,), name="watcher of the rail", daemon=True).start()
        return super().connect()


class BeginsWithADelta(Rail):
    def tell(self, x):
        self.stream("trail", b"1", key=False)


class NeverAKeyAgain(Rail):
    def tell(self, x):
        with self.telling:
            self.stream("trail", b"1", key=self.key)
            self.key = False


class TooLong(Rail):
    def tell(self, x):
        self.stream("trail", bytes((1 << 20) + 1))


class AnotherStream(Rail):
    def tell(self, x):
        self.stream("map", b"1")


class PaceWaits(LockedHold):
    def hold(self):
        return Rail.hold(self)


class NotShown(Rail):
    def set_pace(self, pace):
        pass


class RecoversUnasked(Rail):
    def recover(self, permit):
        return self.connect()


class RecoversTooEarly(Rail):
    def recover(self, permit):
        self.cart.go(2.0)
        permit()
        return self.connect()


class JogsOn(Rail):
    def jog(self, args, free, on_stage):
        self.move(2.0 if args["way"] > 0 else 0.0, free, on_stage)
        self.until_there(lambda: None, on_stage)
        return Outcome()


class CannotBeReplaced(Rail):
    def until_there(self, free, on_stage, alone=False):
        before = self.holds
        while self.state().moving:
            self.go_on(alone)
            self.clock.sleep(0.02)
        if self.holds != before:
            free()


class GoesOnWithoutALine(Rail):
    def until_there(self, free, on_stage, alone=False):
        while self.cart.x() != self.cart.goal or not self.open:
            self.go_on(alone)
            self.clock.sleep(0.02)


class CloseWaits(LockedHold):
    def hold(self):
        return Rail.hold(self)

    def close(self):
        with self.lock:
            super().close()


class LostWithoutWords(Rail):
    def heard(self):
        if self.cart.faults.keys() & {"awol", "power_cycle"}:
            raise OSError(5, "Input/output error")
        super().heard()


class BelievesNoise(Rail):
    def told(self, x, moving):
        return super().told(float("inf") if "corrupt" in self.cart.faults else x, moving)


class IgnoresTheStick(Rail):
    def end_of(self, args):
        self.first = getattr(self, "first", args)
        return super().end_of(self.first)


class AsksOnce(Rail):
    def steered(self, args):
        self.newest = getattr(self, "newest", None) or super().steered(args)
        return self.newest


class GoesOnPastItsTime(Rail):
    def time_left(self):
        return ALONE_S + REST_S


class NeverRests(Rail):
    def go_on(self, alone):
        super().go_on(alone)
        self.cart.go_on(1e6)


class SaysMoreThanItsSpec(Rail):
    def rests_within(self):
        return None if super().rests_within() is None else 1e3


class NeverAtRest(Rail):
    def rests_within(self):
        return super().rests_within() or ALONE_S


class AsksTheWire(Rail):
    def rests_within(self):
        self.heard()
        return super().rests_within()


class NoPicture(Rail):
    def picture(self, view, seconds):
        return b"GIF89a"


BROKEN = [
    (TakesAnything, "values", "execute takes go(x=nan); refuse it with BadRequest"),
    (Complains, "values", "by ValueError"),
    (AsksTooLate, "permit", "although permit() had raised; call permit() before the actuation"),
    (SwallowsTheNo, "permit", "execute answered HardwareFault (It did not work.); let it through as it is"),
    (StagesReversed, "commands", "told the stages ['acknowledged', 'sent']"),
    (ReturnsNothing, "commands", "execute returned NoneType"),
    (EndsEarly, "commands", "The robot moves after go("),
    (FailsWithoutWords, "commands", "ended with KeyError"),
    (IgnoresHold, "hold", "returned a state that moves"),
    (LiesOnHold, "hold", "The robot moves on after hold()"),
    (ForgetsTheHold, "hold", "returned as if nothing had happened"),
    (HoldsForEver, "hold", "A motion after a hold ended with HardwareFault (The cart is held.)"),
    (OnAnotherClock, "state", "stamp it by self.clock.monotonic()"),
    (TellsMore, "state", "tells the channel 'mood', which the spec does not declare"),
    (TellsLess, "state", "does not tell the channel 'pace'"),
    (TellsNoNumber, "state", ") state() tells nan for 'cart'"),
    (TellsTooManyJoints, "state", "tells 2 joints; the spec declares 1"),
    (TellsATwistWithoutAPose, "state", "tells a twist of 3 numbers for a pose of 0"),
    (OffTheRail, "state", "for the joint 'cart', which its scale says lies in"),
    (KeepsNothing, "state", "latest() returns nothing"),
    (TellsNoState, "connect", "connect() returned NoneType instead of a RobotState"),
    (IsEverywhere, "connect", "connect() to an address where nothing is answers no error"),
    (CloseRaises, "end", "close() a second time raised LineGone"),
    (BeginsWithADelta, "streams", "begins with a delta"),
    (NeverAKeyAgain, "streams", "sends no key packet although stream() returned True"),
    (TooLong, "streams", "has 1048577 bytes; send at most 1048576"),
    (AnotherStream, "streams", "It sends the stream 'map'"),
    (RecoversUnasked, "recovery", "recover() never called permit()"),
    (RecoversTooEarly, "recovery", "The robot moved in recover() although permit() had raised"),
    (JogsOn, "held motions", "does not call permit() while it moves"),
    (CannotBeReplaced, "replaced", "did not call permit() on its way"),
    (LostWithoutWords, "lost line", "execute ended with OSError"),
    (BelievesNoise, "noise", "Under the fault 'corrupt' state() tells inf for 'cart'"),
    (AsksOnce, "steered", "does not call steered() while it moves"),
    (GoesOnPastItsTime, "time left", "may move for 2.5 s more, and without a word the robot would rest within"),
    (SaysMoreThanItsSpec, "rests within", "rests_within() says 1000.0 s in go("),
    (NeverAtRest, "rests within", "rests_within() says 5.0 of a robot at rest"),
    (AsksTheWire, "rests within", "answers LineGone (The cart does not answer.) on a silent line"),
    (NoPicture, "pictures", "6 bytes that are no JPEG or PNG"),
]
WAITS_FOR_EVER = [
    (Mute, "commands", "told no stage"),
    (LeavesAThread, "end", "these threads are left: watcher of the rail"),
    (NeverAsks, "permit", "execute never called permit() for go(x="),
    (LockedHold, "hold", 'hold() while on_stage("sent") is told did not return'),
    (PaceWaits, "lanes", "waits for the motion that runs"),
    (NotShown, "lanes", "The channel 'pace' does not show"),
    (GoesOnWithoutALine, "close in motion", "execute did not end after close()"),
    (IgnoresTheStick, "steered", "goes on as it began after newer values had come (jog(way="),
    (NeverRests, "rests within", "and it still moves long after the"),
    (CloseWaits, "close in motion", "close() under a motion did not return"),
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
