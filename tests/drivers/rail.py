"""A cart on a rail in this process, whose driver passes the conformance suite; tests break it in many ways."""

import threading
from io import BytesIO

from PIL import Image

from robots.kit.clock import FasterTimer
from robots.kit.contract.channels import Scalar, Scale
from robots.kit.contract.errors import LineGone
from robots.kit.contract.policies import Bound, Policies, Range
from robots.kit.contract.session import Outcome, Progress, RobotState, Session
from robots.kit.contract.spec import ANYONE, STAFF, Argument, CommandKind, Spec
from robots.kit.contract.streams import Stream
from robots.kit.contract.values import known_command, within
from robots.kit.drivers.permits import until_held

CLOCK = FasterTimer(10)
LENGTH, STEP_S = 2.0, 0.02  # m, s
REST_S, ALONE_S = 1.0, 5.0  # without contact the cart stops after the first, in `go` after the second
ALONE = Policies(on_link_lost=Bound(ALONE_S, (Range("cart", 0.0, LENGTH),), speed=2.0))
SLOW = 0.05  # m/s, so that a motion outlasts what happens in it, on a slow machine too
PACE = Argument("pace", "m/s", SLOW, 2.0)
SPEC = Spec(
    name="Rail",
    joints=("cart",),
    rest_s=REST_S,
    channels=(Scalar("pace", "m/s", 0.0, 2.0),),
    streams=(Stream("trail"),),
    scales={"cart": Scale(-0.01, LENGTH + 0.01, 1e-3), "pace": Scale(0.0, 2.0, 1e-3)},
    commands=(
        CommandKind("go", "Go", (Argument("x", "m", 0.0, LENGTH),), limit_s=60.0, replaceable=True, policies=ALONE,
            shown={"x": "cart"}),
        CommandKind("patrol", "Patrol", limit_s=600.0, asked_by=frozenset({ANYONE, STAFF})),
        CommandKind("jog", "Jog", (Argument("way", "", -1.0, 1.0),), limit_s=60.0, held=True, steered=True),
        CommandKind("noop", "Nothing", limit_s=5.0, moves=False, still_after=False),
        CommandKind(
            "pace", "Pace", (PACE,), lane="config", default={"pace": SLOW}, shown={"pace": "pace"}, moves=False,
            still_after=False,
        ),
    ),
)  # fmt: skip
CAMERA = {"camera": {"by_driver": True, "views": ["rail"], "width": 32, "height": 8}}


class Cart:
    """The hardware: it goes to `goal` at its pace, for as long as it is told to.

    As the board of its faults it falls silent and says wild things.
    """

    def __init__(self):
        self.start = self.goal = 0.0
        self.pace, self.began, self.counted = SLOW, CLOCK.monotonic(), 0
        self.until = 0.0  # it stops then, unless it is told to go on
        self.faults, self.boot = {}, 1

    def x(self):
        way = self.goal - self.start
        done = min(abs(way), self.pace * max(0.0, min(CLOCK.monotonic(), self.until) - self.began))
        return self.start + (done if way > 0 else -done)

    def go(self, goal):
        self.counted += goal != self.x()
        self.start, self.goal, self.began = self.x(), min(max(goal, 0.0), LENGTH), CLOCK.monotonic()
        self.until = max(self.until, self.began + REST_S)

    def go_on(self, seconds):
        now = CLOCK.monotonic()
        if now > self.until:  # it has stopped, and goes on from there
            self.start, self.began = self.x(), now
        self.until = now + seconds

    def stop(self):
        self.start = self.goal = self.x()

    def set(self, verb, value=1.0, count=None):
        self.faults[verb] = value
        self.boot += verb == "power_cycle"
        return True

    def clear(self):
        self.faults.clear()

    def motions(self):
        return self.counted

    def moving(self):
        return CLOCK.monotonic() < self.until and abs(self.x() - self.goal) > 1e-9

    def boots(self):
        return self.boot


class Rail(Session):
    """Its address is the cart itself; anything else is nowhere."""

    clock = CLOCK

    def __init__(self, *args):
        super().__init__(*args)
        self.cart, self.open, self.holds, self.key, self.telling = self.address, False, 0, True, threading.Lock()
        self.alone_until = 0.0

    def heard(self):
        if not self.open or {"awol", "power_cycle"} & set(self.cart.faults):
            raise LineGone("The cart does not answer.")

    def told(self, x, moving):
        speed = (self.cart.pace if self.cart.goal > x else -self.cart.pace) if moving else 0.0
        return RobotState(
            self.clock.monotonic(), (x,), (), moving, True, velocities=(speed,), values={"pace": self.cart.pace}
        )

    def tell(self, x):
        with self.telling:
            self.key = self.stream("trail", b"%f" % x, key=self.key)

    def state(self):
        self.heard()
        x = self.cart.x()
        self.tell(x)
        return self.keep(self.told(x, abs(x - self.cart.goal) > 1e-9))

    def connect(self):
        self.open = isinstance(self.cart, Cart)
        if not self.open:
            raise LineGone("No cart is there.")
        self.key = True
        return self.state()

    def check(self, kind, args):
        within(known_command(SPEC, kind, args), args)

    def execute(self, kind, args, permit, on_stage):
        self.check(kind, args)
        free = until_held(permit, lambda: self.holds)
        if kind in ("noop", "pace"):
            free()
            if kind == "pace":
                on_stage("sent")
                self.set_pace(args["pace"])
                on_stage("acknowledged")
            return Outcome(dict(args), self.latest())
        if kind == "jog":
            return self.jog(args, free, on_stage)
        self.move(args.get("x", LENGTH), free, on_stage)
        while kind == "patrol":
            for goal in (0.0, LENGTH):
                free()
                self.cart.go(goal)
                self.until_there(free, on_stage)
        self.until_there(free, on_stage, alone=kind == "go")
        self.alone_until = 0.0
        return Outcome(dict(args), self.latest())

    def set_pace(self, pace):
        x = self.cart.x()
        self.cart.start, self.cart.began, self.cart.pace = x, CLOCK.monotonic(), pace

    def move(self, goal, free, on_stage):
        free()
        self.heard()
        self.cart.go(goal)
        on_stage("sent")
        on_stage("acknowledged")

    def until_there(self, free, on_stage, alone=False):
        while self.state().moving:
            free()
            self.go_on(alone)
            on_stage(Progress("on its way"))
            self.clock.sleep(STEP_S)
        free()

    def go_on(self, alone):
        seconds = min(ALONE_S, self.time_left() - REST_S) if alone else 0.0
        self.alone_until = CLOCK.monotonic() + seconds if seconds > 0.0 else 0.0
        self.cart.go_on(max(seconds, REST_S))

    def rests_within(self):
        left = self.alone_until - CLOCK.monotonic()
        return left if left > 0.0 else None

    def jog(self, args, free, on_stage):
        try:
            self.move(self.end_of(args), free, on_stage)
            while True:
                free()
                self.go_on(alone=False)
                if self.end_of(newest := self.steered(args)) != self.cart.goal:
                    self.cart.go(self.end_of(newest))
                self.state()
                self.clock.sleep(STEP_S)
        finally:
            if self.open:
                self.cart.stop()

    def end_of(self, args):
        return LENGTH if args["way"] > 0 else 0.0

    def hold(self):
        self.holds += 1
        self.heard()
        self.cart.stop()
        self.alone_until = 0.0
        return self.state()

    def close(self):
        self.open = False

    def picture(self, view, seconds):
        data = BytesIO()
        Image.new("L", (32, 8)).save(data, "PNG")
        return data.getvalue()
