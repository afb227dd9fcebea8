"""Motions of the rover from rest to rest: by hand, to a place, in place, on patrol. Each ends with a hold."""

from collections.abc import Callable
from math import hypot, remainder, tau

from robots.kit.clock import Timer
from robots.kit.contract.errors import ControlsReleased, GaveUp, LineGone, LineSilent
from robots.kit.contract.session import Permit
from robots.kit.description import load
from robots.kit.drivers.srv1.answers import Status
from robots.kit.drivers.srv1.following import TURNED_RAD, Pose, is_reached, room_ahead, toward, turning
from robots.kit.drivers.srv1.rounds import Round
from robots.kit.drivers.srv1.spec import Mode
from robots.kit.drivers.srv1.ways import Place, length, way
from robots.kit.drivers.srv1.wheels import Wheels

BLOCKED_S = 10.0  # something stands in its way for so long: it gives up
MARGIN_M = 0.03  # before the reflex, where it counts as blocked
CLEAR_M = 0.10  # the sonar must see by so much farther than at the stop before it goes on
NEVER_BEGAN = "The rover did not move: what it was told came too late over its line."
UNHEARD = "out of reach: it drives on by itself, and rests within {:.0f} s if it is not reached"
STUCK_S = 6.0  # commanded to move, and no farther in so long
STUCK = "The rover does not move: it stands against something. Staff or its driver have to free it."
ENCODER = (
    "An encoder counts nothing while its wheels are driven: it is broken, or they are held fast. The rover does not "
    "know where it is; staff have to look at it."
)
TOO_NEAR = "Something is too near ahead: the rover only turns, and drives back."
IN_THE_WAY = f"Something stands in the rover's way. It waited {BLOCKED_S:.0f} s."
Began = Callable[[], None]  # called when the rover has understood; only its first call counts
Left = Callable[[float, float], None]  # called with the metres that are left of a way, and the share that is done


class Progressing:
    """Notices that the rover is commanded to move and does not: it stands against something that no sensor sees."""

    def __init__(self, clock: Timer) -> None:
        self._clock = clock
        self.rests()

    def rests(self) -> None:
        """Begin anew: the rover is not commanded to move."""
        self._since: float = self._clock.monotonic()
        self._from: Pose | None = None

    def check(self, pose: Pose) -> None:
        """Take its pose. Raises GaveUp if it has not moved for long."""
        if self._from is None or _has_moved(self._from, pose):
            self._since, self._from = self._clock.monotonic(), pose
        elif self._clock.monotonic() - self._since > STUCK_S:
            raise GaveUp(STUCK)


def _has_moved(was: Pose, pose: Pose) -> bool:
    return hypot(pose[0] - was[0], pose[1] - was[1]) > 0.03 or abs(remainder(pose[2] - was[2], tau)) > 0.1


class Motions:
    """The motions of one rover, one at a time. Each raises what `permit` and the wheels raise."""

    def __init__(self, wheels: Wheels) -> None:
        described = load("srv1")
        self.wheels, self._motion = wheels, described["motion"]
        self._stop, self._sonar = float(described["infrared"]["stop"]), described["sonar"]
        self._clock = wheels.clock
        self._round = Round()
        self._before = 0  # the number of the motion before the one that runs

    def drive(self, wanted: Callable[[], tuple[float, float]], permit: Permit, began: Began) -> None:
        """Drive with shares (-1 to 1) of the greatest velocities, ahead and turning, until `permit` ends it.

        `wanted` is asked again and again. Raises GaveUp if the rover never began.
        """
        most, fastest_turn = float(self._motion["most_speed"]), float(self._motion["turn"]) / 2
        before, linear, sent = self.wheels.ask(), 0.0, False

        def act(free: Permit) -> None:
            nonlocal linear, sent
            while True:
                status = self.wheels.next_status()
                forward, turn = wanted()
                linear = forward * most
                self.wheels.drive(linear, turn * fastest_turn, status, free)
                sent = sent or (forward, turn) != (0.0, 0.0)
                began()
                self.wheels.pause()

        try:
            self.wheels.during(permit, Mode.HAND, act)
        except ControlsReleased:
            status = self.wheels.ask()
            if sent and status.motion == before.motion:
                near = status.infrared < self._stop or status.sonar < self._sonar["free"]
                raise GaveUp(TOO_NEAR if linear > 0 and near else NEVER_BEGAN) from None
            raise

    def go(self, goal: Place, permit: Permit, began: Began, left: Left) -> float:
        """Go to a place over the nodes of the map; return how long the way is (m).

        Raises OutOfWorkspace; GaveUp where something stands in the way.
        """
        begin = self._pose(self._first())[:2]
        corners = way(begin, goal)
        whole = length(begin, corners)

        def act(free: Permit) -> None:
            start = begin
            for number, corner in enumerate(corners):
                self._along(start, corner, number < len(corners) - 1, free, began, corners[number:], whole, left)
                start = corner
            began()

        self.wheels.during(permit, Mode.GOING, act)
        return whole

    def _along(
        self, begin: Place, end: Place, passes: bool, permit: Permit, began: Began, corners: list[Place],
        whole: float, left: Left,
    ) -> None:  # fmt: skip
        """Drive along one line of a way. Raises GaveUp where something stands in it for long."""
        fastest, braking = float(self._motion["most_speed"]), float(self._motion["acceleration"])
        free_at, progress, margin = self._clock.monotonic(), Progressing(self._clock), 0.0
        while True:
            status = self._asked()
            pose = self._pose(status)
            if is_reached(pose, begin, end, passes):
                return
            metres = hypot(end[0] - pose[0], end[1] - pose[1])
            room = room_ahead(
                status.infrared, status.sonar, self._stop + MARGIN_M, self._sonar["close"] + margin, metres
            )  # fmt: skip
            v, w = toward(pose, begin, end, fastest, room, braking)
            margin = 0.0 if v else CLEAR_M
            if v or w:
                free_at, self.wheels.mode = self._clock.monotonic(), Mode.GOING
                progress.check(pose)
                self.wheels.drive(v, w, status, permit)
                began()
            else:
                self.wheels.mode = Mode.WAITING
                progress.rests()
                permit()
                if self._clock.monotonic() - free_at > BLOCKED_S:
                    raise GaveUp(IN_THE_WAY)
            metres = length((pose[0], pose[1]), corners)
            left(metres, min(max(1.0 - metres / max(whole, 0.1), 0.0), 1.0))
            self.wheels.pause()

    def turn(self, angle: float, permit: Permit, began: Began) -> None:
        """Turn in place by so much (rad, to the left), by the odometry."""
        last, todo, progress = self._first(), angle, Progressing(self._clock)

        def act(free: Permit) -> None:
            nonlocal last, todo
            while abs(todo) > TURNED_RAD:
                self.wheels.drive(0.0, turning(todo), last, free)
                began()
                self.wheels.pause()
                status = self._asked()
                progress.check((status.x, status.y, status.heading))
                todo -= remainder(status.heading - last.heading, tau)
                last = status
            began()

        self.wheels.during(permit, Mode.TURNING, act)

    def patrol(self, seconds: float, permit: Permit, began: Began, tell: Callable[[str], None]) -> float:
        """Let the rover drive by its rules for so long (s), on its round where its place is known.

        Return how far it came (m). If its line is lost it drives on by its permit meanwhile, and `tell` reports that.
        """
        until, driven = self._clock.monotonic() + seconds, self.wheels.where.driven
        self._first()
        self._round.restart()

        def act(free: Permit) -> None:
            goal = ""
            while self._clock.monotonic() < until:
                try:
                    self._lead(self._asked(), free)
                except (LineGone, LineSilent):
                    if not self.wheels.alone.remaining_s:
                        raise
                    tell(UNHEARD.format(self.wheels.alone.rests_within))
                    self.wheels.find_again(free)
                    goal = ""
                    self._round.restart()
                    continue
                began()
                if self._round.goal != goal:
                    goal = self._round.goal
                    tell(f"on the way to {goal}")
                self.wheels.pause()

        self.wheels.during(permit, Mode.PATROL, act)
        return self.wheels.where.driven - driven

    def _lead(self, status: Status, permit: Permit) -> None:
        """Let the rover drive by its rules until the next message, on its round where its place is known."""
        aside = 0.0
        if self.wheels.where.is_known:
            near = status.infrared < self._stop + MARGIN_M or status.sonar < self._sonar["close"]
            aside = self._round.aside(self._pose(status), near)
        self.wheels.patrol(status, permit, aside)

    def wait(self, seconds: float, permit: Permit) -> None:
        """Stay where it is, for as long as `permit` allows it."""
        until = self._clock.monotonic() + seconds
        while self._clock.monotonic() < until:
            permit()
            self.wheels.ask()
            self.wheels.pause()

    def _first(self) -> Status:
        """Ask the rover before it moves."""
        status = self.wheels.ask()
        self._before = status.motion
        return status

    def _asked(self) -> Status:
        """Ask the rover. Raises GaveUp where an encoder is dead in a motion that has begun since `_first`."""
        status = self.wheels.next_status()
        if status.dead_encoders and status.motion != self._before:
            raise GaveUp(ENCODER)
        return status

    def _pose(self, status: Status) -> Pose:
        return self.wheels.where.pose(status)
