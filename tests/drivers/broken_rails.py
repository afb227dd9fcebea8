"""The cart on a rail with drivers that are each broken in one way, which the conformance suite has to name."""

import threading
from dataclasses import replace
from io import BytesIO

from PIL import Image

from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import HardwareFault, LineGone
from robots.kit.contract.session import Outcome, Progress, RobotState
from tests.drivers.rail import ALONE_S, REST_S, Cart, Rail


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


class StopsShort(Rail):
    def move(self, goal, free, on_stage):
        self.cart.pace = 100.0  # so that it ends while it is watched
        super().move(goal * 0.9, free, on_stage)


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


class AnotherShape(Rail):
    def picture(self, view, seconds):
        data = BytesIO()
        Image.new("L", (32, 9)).save(data, "PNG")
        return data.getvalue()


class NoPicture(Rail):
    def picture(self, view, seconds):
        return b"GIF89a"
