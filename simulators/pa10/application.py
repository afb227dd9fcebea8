"""The control application (Dziemian et al. 2004, figures 2 and 4): requests in, a reference out.

The network's threads call `take`; the control thread calls `step` every 2 ms and gets the reference for the
controller. One lock protects the register; planning runs without it. A target is planned from where the reference
will be in a moment, checked against the boxes, and started at that moment, so the planned path is the path that is
driven. Time is the control loop's own, 2 ms per step: if a busy machine stalls the loop, arm and reference stall
together.
"""

import threading
from contextlib import AbstractContextManager

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.planner import Refused
from robots.kit.arms.zones import Box
from robots.kit.clock import TIMER, Limit, Timer, Until
from robots.kit.drivers.pa10.courses import Course, Courses, is_default
from robots.kit.drivers.pa10.protocol import MOTIONS, VELOCITIES, End, Malformed, Mode, Request, program
from simulators.common.arm.position_guard import PositionGuard
from simulators.common.arm.setpoint import Reference, SetPoint
from simulators.common.journal import Note
from simulators.pa10 import runner
from simulators.pa10.runner import GRIP_S
from simulators.pa10.scene import STEP_S
from simulators.pa10.store import ProgramStore

AHEAD_S, MOST_AHEAD_S = 0.06, 1.0  # least and greatest lead of a target that is sent during a motion
DEAD_MAN_S = 0.25  # a velocity ends unless it is repeated within that time
PLANS = 4  # attempts for one target while the arm moves on
STILL_RAD_S = 0.02  # below this the measured arm rests
MOST_BOXES = 32
WAY_OUT = "only j 0 0 0 0 0 0 leads out of it"


class Application:
    """State machine and safety. `note` writes to the journal, where `at` is the loop's time (s).

    `error`: a range error in which the arm still is.
    """

    def __init__(
        self, courses: Courses, q: Joints, note: Note, store: ProgramStore, gripper: int = 0, error: str = "",
        extra: tuple[Box, ...] = (), clock: Timer = TIMER,
    ) -> None:  # fmt: skip
        self._courses, self._note, self._store, self._clock = courses, note, store, clock
        self._lock = threading.RLock()
        self._rested = threading.Condition(self._lock)
        self._mode, self._end = Mode.NO_CTRL, End.NONE
        self._set = SetPoint(courses.planner, q, DEAD_MAN_S)
        self._guard = PositionGuard(courses.planner, q)
        self._seen, self._speed = q.copy(), np.zeros_like(q)
        self._leaving = ""  # the range error that is being left now
        self._gripper, self._gripped = gripper, 0  # the step until which the fingers may move
        self._ticks, self._now = 0, 0.0  # steps of the control loop, and its time in s
        self._took = 0.0  # duration of the newest plan, in that time
        self.extra = extra  # boxes beside the arm's own
        self._holds = 0  # number of holds, so that older requests notice one
        self.motion, self.program, self.step_of, self.note = 0, 0, 0, ""
        if error:
            with self._rested:
                self._range_error(error)

    # what the network calls

    @property
    def hold_count(self) -> int:
        """Return a number that changes with each hold."""
        return self._holds

    def take(self, request: Request, holds: int | None = None) -> str:
        """Start a request; return the line to answer. Raises Refused, Malformed.

        `holds` is the `hold_count` at the time when the request arrived; a request that was held before it could start
        does not start.
        """
        holds = self._holds if holds is None else holds
        letter = request.letter
        if letter == "h":
            self.hold()
            return "ok hold"
        if letter not in (*MOTIONS, *VELOCITIES, *"gpb"):
            raise Malformed(f"{letter} is not a request to the arm")
        with self._lock:
            self._none_came_first(holds)
            if letter == "b":
                return self._forbid(request)
            self._must_be_free_for(request)
        if letter in MOTIONS:
            return f"ok {self.move(request, holds)}"
        if letter in (*VELOCITIES, "g"):
            with self._lock:
                self._none_came_first(holds)
                if letter == "g":
                    self.grip(request.numbers[0])
                    return "ok gripper"
                self._drive(request)
                return "ok velocity"
        return self._execute(int(request.numbers[0]), holds)

    def _must_be_free_for(self, request: Request) -> None:
        if self._leaving and not is_default(request):
            raise Refused("range", f"the arm is on its way out of a range error; {WAY_OUT}")
        if self._mode == Mode.RANGE_ERROR and not is_default(request):
            raise Refused("range", f"{self.note or 'range error'}; {WAY_OUT}")
        if self._mode == Mode.PROG_EXEC:
            raise Refused("busy", f"program {self.program} is executing; hold it first")
        if self._mode == Mode.RANGE_ERROR:
            if (np.abs(self._speed) > STILL_RAD_S).any():
                raise Refused("busy", "something still moves the arm; wait until it rests")
            self._set.stand(self._seen)
            self._guard.accept(self._courses.planner, self._seen)

    def _none_came_first(self, asked: int) -> None:
        if self._holds != asked and self._mode == Mode.RANGE_ERROR:
            raise Refused("range", f"{self.note}; {WAY_OUT}")
        if self._holds != asked:
            raise Refused("busy", "a hold came before it could begin")

    def move(self, request: Request, holds: int, in_program: bool = False) -> int:
        """Plan and start a motion; return its number. Raises Refused."""
        why = ""
        for _ in range(PLANS):
            with self._lock:
                self._none_came_first(holds)
                moving, follows, motion = self._set.in_motion, self._set.follows(), self.motion
                begun, at = self._now, self._now + min(MOST_AHEAD_S, max(AHEAD_S, 2 * self._took))
                q, v = self._set.ahead(at)
            course = self._courses.plan(request, q, v)
            with self._lock:
                self._took = self._now - begun
                self._none_came_first(holds)
                if (self._mode == Mode.PROG_EXEC) != in_program:
                    raise Refused("busy", f"program {self.program} began first")
                if self.motion != motion or self._set.follows() is not follows:
                    why = "another motion began while this one was planned"
                elif moving and self._now > at:
                    why = f"planning took {1000 * self._took:.0f} ms and the arm had gone on by then"
                else:
                    return self._install(course, at if moving else self._now)
        raise Refused("busy", f"{why}, {PLANS} times; give the target again")

    def _install(self, course: Course, at: float) -> int:
        if self._set.on_path:
            self._finish(End.REPLACED)
        self.motion += 1
        self._end = End.NONE
        if self._mode == Mode.RANGE_ERROR:
            self._leaving = self.note
        if self._mode != Mode.PROG_EXEC:
            self._mode = course.mode
        self.note = ""
        self._set.take(course.plan.path, at)
        self._note("motion", motion=self.motion, target=[round(float(v), 6) for v in course.plan.target],
                   seconds=round(course.plan.path.seconds, 4))  # fmt: skip
        return self.motion

    def _drive(self, request: Request) -> None:
        values = np.array(request.numbers)
        values = np.radians(values) if request.letter == "J" else np.append(values[:3] / 1000, np.radians(values[3:]))
        if self._set.on_path:
            raise Refused("busy", "a motion runs; hold it first")
        if self._set.drive(request.letter != "J", values, self._now):
            self.motion += 1
            self._end = End.NONE
            self._note("motion", motion=self.motion, velocity=request.letter)
        self._mode = Mode.JOINT_CTRL if request.letter == "J" else Mode.KIN_RPY_CTRL

    def grip(self, value: float) -> None:
        """Open (0) or close (1) the gripper."""
        with self._lock:
            self._gripper, self._gripped = int(value), self._ticks + round(GRIP_S / STEP_S)
            self._note("gripper", closed=int(value))

    def hold(self) -> None:
        """Bring the arm to rest; a program ends."""
        with self._rested:
            if self._mode == Mode.PROG_EXEC and not self.note:
                self.note = f"program {self.program} was held at step {self.step_of}"
            self._holds += 1
            self.program = self.step_of = 0
            self._set.brake(self._now)
            if self._end == End.NONE and self.motion:
                self._finish(End.HELD)
            if self._leaving:
                self._mode, self.note, self._leaving = Mode.RANGE_ERROR, self._leaving, ""
            if self._mode != Mode.RANGE_ERROR:
                self._mode = Mode.NO_CTRL
            self._note("hold", at=round(self._now, 4))
            self._rested.notify_all()

    def _forbid(self, request: Request) -> str:
        """Add a forbidden box, or remove the added ones; valid from the next step on."""
        if not request.numbers:
            self.extra = ()
        elif len(self.extra) >= MOST_BOXES:
            raise Refused("busy", f"there are {MOST_BOXES} more boxes already; remove them with b first")
        else:
            corners = np.array(request.numbers).reshape(2, 3) / 1000
            low, high = corners.min(axis=0), corners.max(axis=0)
            box = Box(request.word.replace("_", " "), tuple(low.tolist()), tuple(high.tolist()))
            self.extra = (*self.extra, box)
        self._courses.forbid(self.extra)
        self._set.planner = self._courses.planner
        self._guard.accept(self._courses.planner, self._seen)
        self._set.look_again()
        self._note("boxes", extra=[b.name for b in self.extra])
        return f"ok {len(self.extra)} boxes"

    def _finish(self, end: End) -> None:
        self._end = end
        self._note("end", motion=self.motion, end=str(end))

    # programs

    def _execute(self, number: int, asked: int) -> str:
        text = self._store.text(number)
        if text is None:
            known = ", ".join(map(str, self._store.numbers()[:20])) or "none"
            raise Refused("range", f"there is no program {number}; known: {known}")
        try:
            steps = program(text)
        except Malformed as error:
            raise Refused("range", f"program {number}: {error}") from error
        with self._lock:
            if self.busy:
                raise Refused("busy", "a program begins at rest: hold the arm first")
            q = self._set.q.copy()
        seconds = self._courses.check(steps, q, lambda: self._none_came_first(asked))
        with self._lock:
            self._none_came_first(asked)
            if self.busy or self._mode == Mode.RANGE_ERROR:
                raise Refused("busy", "the arm was moved while the program was checked")
            runner.start(self, steps, self._holds, self._clock)  # waits for this lock; there may be no thread left
            self._mode, self.program, self.step_of, self.note = Mode.PROG_EXEC, number, 0, ""
            self._note("program", number=number, steps=len(steps))
        return f"ok program {number} {seconds:.1f} s"

    def step_began(self, number: int, mine: int) -> bool:
        """See `runner.Arm`."""
        with self._lock:
            if self._holds == mine:
                self.step_of = number
            return self._holds == mine

    def program_ended(self, mine: int, error: str = "") -> None:
        """See `runner.Arm`."""
        with self._lock:
            if self._holds != mine:
                return
            if error:
                self.note = f"program {self.program}, {error}"
                self.hold()
            else:
                self._mode, self.program, self.step_of = Mode.NO_CTRL, 0, 0
                self._note("program_end")

    def wait(self, mine: int, seconds: float, rest: bool) -> None:
        """See `runner.Arm`."""
        with self._rested:
            until = self._ticks + seconds / STEP_S

            def over() -> bool:
                return self._holds != mine or self._ticks >= until or (rest and not self._set.on_path)

            while not self._clock.wait(Until(self._rested, over), 0.02):
                pass

    # what the control thread calls

    def step(self, measured: Joints, speed: Joints) -> Reference:
        """Return the reference 2 ms later; checks the measured position (rad, rad/s)."""
        with self._rested:
            self._ticks += 1
            self._now = self._ticks * STEP_S
            self._seen, self._speed = measured, speed
            if self._set.step(self._now):
                self._arrive()
            if self._mode != Mode.RANGE_ERROR and (why := self._guard.violation(measured)):
                self._range_error(why)
            return Reference(self._set.q, self._set.v, self._set.a, self._gripper)

    def _arrive(self) -> None:
        if self._end == End.NONE:
            self._finish(End.DONE)
            self._leaving = ""
        if self._mode not in (Mode.PROG_EXEC, Mode.RANGE_ERROR):
            self._mode = Mode.NO_CTRL
        self._note("rest", motion=self.motion, at=round(self._now, 4))
        self._rested.notify_all()

    def _range_error(self, why: str) -> None:
        """Stop because the measured arm, not its reference, is where it must not be. The caller has the lock."""
        self._leaving = ""
        if self.busy:
            self.hold()
        self._holds += 1
        self._set.stand(self._seen)  # rest here
        self._guard.accept(self._courses.planner, self._seen)
        self._end, self._mode, self.note = End.RANGE, Mode.RANGE_ERROR, why.replace("°", " deg")
        self._note("range_error", why=self.note)
        self._rested.notify_all()

    # what others read

    @property
    def unchanged(self) -> AbstractContextManager[bool]:
        """Return the lock under which several of these values can be read at one moment."""
        return self._lock

    @property
    def mode(self) -> Mode:
        """Return the register."""
        return self._mode

    @property
    def end(self) -> End:
        """Return how the newest motion ended."""
        return self._end

    @property
    def gripper(self) -> int:
        """Return the commanded gripper: 0 open, 1 closed."""
        return self._gripper

    @property
    def error(self) -> str:
        """Return the range error in which the arm still is, empty if there is none."""
        with self._lock:
            return self._leaving or (self.note if self._mode == Mode.RANGE_ERROR else "")

    @property
    def moving(self) -> bool:
        """Return whether the set-point moves."""
        return self._set.moving

    @property
    def busy(self) -> bool:
        """Return whether the arm executes something."""
        return self.moving or self._mode == Mode.PROG_EXEC or self._ticks < self._gripped

    def letter(self) -> str:
        """Return the paper's answer to `w`: a awaiting, b busy, e error."""
        with self._lock:
            if self._mode == Mode.RANGE_ERROR:
                return "e"
            return "b" if self.busy else "a"

    def wait_for_rest(self, seconds: float) -> str:
        """Wait while the arm moves (`W`); return as `letter`."""
        limit, rests = Limit(self._clock, seconds), Until(self._rested, lambda: not self.busy)
        with self._rested:
            while not self._clock.wait(rests, 0.02) and not limit.over:
                pass
        return self.letter()
