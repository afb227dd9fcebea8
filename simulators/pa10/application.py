"""The control application (Dziemian et al. 2004, figures 2 and 4): requests in, a reference out.

The network's threads call `take`; the control thread calls `step` once in 2 ms and gets the
reference for the controller. Between them stands one lock around the register, never around
planning: a target is planned from where the reference will be in a moment, swept against the
boxes, and taken up when that moment comes, so a planned way is the way that is driven.
Time is the control loop's own, 2 ms a step: where a crowded machine stalls the loop, arm and
reference stall together.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robots.drivers.pa10.courses import Course, Courses, is_default
from robots.drivers.pa10.protocol import MOTIONS, End, Malformed, Mode, Request, program
from robots.motion.chain import Joints
from robots.motion.path import Path
from robots.motion.planner import Refused
from robots.motion.zones import Box
from simulators.pa10.scene import STEP_S

AHEAD_S = 0.06  # a blending target is planned from the reference so much later
DEAD_MAN_S = 0.25
OFF_M = 0.005  # how far the measured arm may be inside a box before it counts as there
OFF_RAD = 0.05  # the same for the mechanical range of a joint
GRIP_S = 0.8
STILL_RAD_S = 0.02  # below it the arm, not its set-point, rests
LOOK_S = 0.01  # a velocity command is looked ahead of so often
Note = Callable[..., None]


@dataclass(frozen=True)
class Reference:
    """What the controller has to follow: rad, rad/s, rad/s2; gripper 0 open, 1 closed."""

    q: Joints
    v: Joints
    a: Joints
    gripper: int


class Application:
    """State machine, planning, safety. `note` writes to the journal."""

    def __init__(self, courses: Courses, q: Joints, note: Note, programs: dict[int, str], gripper: int = 0) -> None:
        self._courses, self._note, self.programs = courses, note, programs
        planner = self._planner = courses.planner
        self._lock = threading.RLock()
        self._rested = threading.Condition(self._lock)
        self._mode, self._end = Mode.NO_CTRL, End.NONE
        self._path: Path | None = None
        self._next: tuple[float, Course] | None = None  # when a blend takes over
        self._began = 0.0
        zero = np.zeros_like(q)
        self._q, self._v, self._a = q.copy(), zero, zero
        self._wish: tuple[str, Joints, float] | None = None  # velocity command: kind, values, until
        self._floor = planner.zones.floor(planner.zones.distances(q))
        self._outside = np.full_like(q, OFF_RAD)  # how far outside its range each joint may be for now
        self._free_until = 0.0  # a velocity command was found free up to then
        self._seen, self._thrown = q.copy(), False
        self._gripper, self._gripped = gripper, 0  # until which step the fingers may be on their way
        self._ticks, self._now = 0, 0.0  # steps of the control loop, and its time in s
        self._extra: tuple[Box, ...] = ()
        self._running = 0  # how many holds and programs there were, so that what is older than one knows
        self.motion, self.program, self.step_of, self.note = 0, 0, 0, ""

    # what the network asks

    @property
    def asked(self) -> int:
        """Return a number that changes with each hold and each program."""
        return self._running

    def take(self, request: Request, asked: int | None = None) -> str:
        """Begin what is asked; return the line to answer. Raises Refused, Malformed.

        `asked` is what the property of that name said when the request came: what was held
        before it could begin does not begin.
        """
        asked = self._running if asked is None else asked
        letter = request.letter
        if letter == "h":
            self.hold()
            return "ok hold"
        with self._lock:
            if letter == "b":
                return self._forbid(request)
            if self._mode == Mode.RANGE_ERROR and not is_default(request):
                raise Refused("range", f"{self.note or 'range error'}; only j 0 0 0 0 0 0 leads out of it")
            if self._mode == Mode.PROG_EXEC:
                raise Refused("busy", f"program {self.program} is executing; hold it first")
            if self._mode == Mode.RANGE_ERROR:
                if self._thrown:
                    raise Refused("busy", "something still moves the arm; wait until it rests")
                self._stand_where_it_is()
        if letter in MOTIONS:
            return f"ok {self._move(request, asked)}"
        if letter in "JC":
            self._wish_for(request)
            return "ok velocity"
        if letter == "g":
            self._grip(request.numbers[0])
            return "ok gripper"
        return self._execute(int(request.numbers[0]), asked)

    def _none_came_first(self, asked: int) -> None:
        if self._running != asked:
            raise Refused("busy", "a hold came before it could begin")

    def _move(self, request: Request, asked: int) -> int:
        """Plan and take up a motion; return its number."""
        for _ in range(3):
            with self._lock:
                self._none_came_first(asked)
                moving = self._path is not None or bool(np.any(np.abs(self._v) > 1e-9))
                at = self._now + AHEAD_S
                q, v = self._ahead(at)
                motion, path, wish = self.motion, self._path, self._wish
            course = self._courses.plan(request, q, v)
            with self._lock:
                self._none_came_first(asked)
                same = self.motion == motion and self._path is path and self._wish is wish
                if not same or (moving and self._now > at):
                    continue  # the arm went another way meanwhile, or planning took too long
                return self._install(course, at if moving else self._now)
        raise Refused("busy", "the arm moves too lively to change its target; hold it first")

    def _ahead(self, at: float) -> tuple[Joints, Joints]:
        if self._path is not None:
            q, v, _ = self._path.at(at - self._began)
            return q, v
        if np.any(np.abs(self._v) > 1e-9):
            raise Refused("busy", "the arm is driven by velocities; let it come to rest first")
        return self._q.copy(), self._v.copy()

    def _install(self, course: Course, at: float) -> int:
        if self._path is not None:
            self._finish(End.REPLACED)
        self.motion += 1
        self._end = End.NONE
        if self._mode != Mode.PROG_EXEC:
            self._mode = course.mode
        self.note = ""
        self._next = (at, course)
        self._note("motion", motion=self.motion, target=[round(float(v), 6) for v in course.plan.target],
                   seconds=round(course.plan.path.seconds, 4))  # fmt: skip
        return self.motion

    def _wish_for(self, request: Request) -> None:
        values = np.array(request.numbers)
        values = np.radians(values) if request.letter == "J" else np.append(values[:3] / 1000, np.radians(values[3:]))
        with self._lock:
            if self._path is not None or self._next is not None:
                raise Refused("busy", "a motion runs; hold it first")
            if self._wish is None:
                self.motion += 1
                self._end = End.NONE
                self._note("motion", motion=self.motion, velocity=request.letter)
            if self._wish is None or np.any(self._wish[1] != values):
                self._free_until = 0.0
            self._wish = request.letter, values, self._now + DEAD_MAN_S
            self._mode = Mode.JOINT_CTRL if request.letter == "J" else Mode.KIN_RPY_CTRL

    def _grip(self, value: float) -> None:
        if value not in (0.0, 1.0):
            raise Refused("range", "the gripper knows 0 (open) and 1 (close)")
        with self._lock:
            self._gripper, self._gripped = int(value), self._ticks + round(GRIP_S / STEP_S)
            self._note("gripper", closed=int(value))

    def hold(self) -> None:
        """Bring the arm to rest; a program is broken off."""
        with self._rested:
            if self._mode == Mode.PROG_EXEC and not self.note:
                self.note = f"program {self.program} was held at step {self.step_of}"
            self._running += 1
            self.program = self.step_of = 0
            self._wish = self._next = None
            if np.any(np.abs(self._v) > 1e-9):
                self._path, self._began = self._planner.brake(self._q, self._v), self._now
            elif self._path is not None:
                self._path = None
            if self._end == End.NONE and self.motion:
                self._finish(End.HELD)
            if self._mode != Mode.RANGE_ERROR:
                self._mode = Mode.NO_CTRL
            self._note("hold")
            self._rested.notify_all()

    def _forbid(self, request: Request) -> str:
        """Take one more forbidden box, or forget those that were taken; judged from the next step on."""
        if not request.numbers:
            self._extra = ()
        else:
            corners = np.array(request.numbers).reshape(2, 3) / 1000
            low, high = corners.min(axis=0), corners.max(axis=0)
            box = Box(request.word.replace("_", " "), tuple(low.tolist()), tuple(high.tolist()))
            self._extra = (*self._extra, box)
        self._courses.forbid(self._extra)
        planner = self._planner = self._courses.planner
        self._floor, self._free_until = planner.zones.floor(planner.zones.distances(self._seen)), 0.0
        self._note("boxes", extra=[b.name for b in self._extra])
        return f"ok {len(self._extra)} boxes"

    def _finish(self, end: End) -> None:
        self._end = end
        self._note("end", motion=self.motion, end=str(end))

    # programs

    def _execute(self, number: int, asked: int) -> str:
        if number not in self.programs:
            known = ", ".join(map(str, sorted(self.programs))) or "none"
            raise Refused("range", f"there is no program {number}; known: {known}")
        try:
            steps = program(self.programs[number])
        except Malformed as error:
            raise Refused("range", f"program {number}: {error}") from error
        with self._lock:
            if self.busy:
                raise Refused("busy", "a program begins at rest: hold the arm first")
            q = self._q.copy()
        seconds = self._courses.check(steps, q, lambda: self._none_came_first(asked))
        with self._lock:
            self._none_came_first(asked)
            self._running += 1
            mine = self._running
            self._mode, self.program, self.step_of, self.note = Mode.PROG_EXEC, number, 0, ""
            self._note("program", number=number, steps=len(steps))
        threading.Thread(target=self._run, args=(steps, mine), name="program", daemon=True).start()
        return f"ok program {number} {seconds:.1f} s"

    def _run(self, steps: list[Request], mine: int) -> None:
        for number, step in enumerate(steps, 1):
            with self._lock:
                if self._running != mine:
                    return
                self.step_of = number
            try:
                self._one(step, mine)
            except Refused as error:
                with self._lock:
                    if self._running == mine:
                        self.note = f"program {self.program}, step {number}: {error}"
                        self.hold()
                return
        with self._lock:
            if self._running == mine:
                self._mode, self.program, self.step_of = Mode.NO_CTRL, 0, 0
                self._note("program_end")

    def _one(self, step: Request, mine: int) -> None:
        if step.letter in MOTIONS:
            self._move(step, mine)
            self._wait(mine, np.inf)
        elif step.letter == "g":
            self._grip(step.numbers[0])
            self._wait(mine, GRIP_S, rest=False)
        elif step.letter == "d":
            self._wait(mine, step.numbers[0], rest=False)

    def _wait(self, mine: int, seconds: float, rest: bool = True) -> None:
        """Wait until the arm rests, or for `seconds` of the control loop; broken off where the program is."""
        with self._rested:
            until = self._ticks + seconds / STEP_S
            while self._running == mine and self._ticks < until:
                if rest and self._path is None and self._next is None:
                    return
                self._rested.wait(0.02)

    # what the control thread does

    def step(self, measured: Joints, speed: Joints) -> Reference:
        """Return the reference 2 ms on; judges where the arm really is (rad, rad/s)."""
        with self._rested:
            self._ticks += 1
            now = self._now = self._ticks * STEP_S
            self._seen, self._thrown = measured, bool(np.any(np.abs(speed) > STILL_RAD_S))
            if self._next is not None and now >= self._next[0]:
                self._began, course = self._next
                self._path, self._next, self._wish = course.plan.path, None, None
            if self._path is not None:
                t = now - self._began
                self._q, self._v, self._a = self._path.at(t)
                if t >= self._path.seconds and self._next is None:
                    self._arrive()
            elif self._wish is not None:
                self._follow_wish(now)
            self._judge(measured)
            return Reference(self._q, self._v, self._a, self._gripper)

    def _arrive(self) -> None:
        self._path = None
        self._v = np.zeros_like(self._v)
        self._a = np.zeros_like(self._a)
        if self._end == End.NONE:
            self._finish(End.DONE)
        if self._mode not in (Mode.PROG_EXEC, Mode.RANGE_ERROR):
            self._mode = Mode.NO_CTRL
        self._note("rest", motion=self.motion)
        self._rested.notify_all()

    def _follow_wish(self, now: float) -> None:
        """Drive by velocities: as asked, no faster than may be braked before a limit or a box."""
        assert self._wish is not None
        letter, values, until = self._wish
        limits, dt = self._planner.limits, STEP_S
        wanted = np.zeros_like(self._v)
        if now < until:
            wanted = values if letter == "J" else self._planner.hand_velocity(self._q, values)
            wanted = wanted / max(1.0, float(np.max(np.abs(wanted) / limits.velocity)))
            if now >= self._free_until:
                self._free_until = now + LOOK_S if self._may_go_on(wanted) else 0.0
            if not self._free_until:
                wanted = np.zeros_like(self._v)
        change = np.clip(wanted - self._v, -limits.acceleration * dt, limits.acceleration * dt)
        self._a = change / dt
        self._v = self._v + change
        self._q = self._q + self._v * dt
        if now >= until and not np.any(np.abs(self._v) > 1e-9):
            self._wish = None
            self._arrive()

    def _may_go_on(self, wanted: Joints) -> bool:
        """Tell whether the arm could still brake in time after one more step at the wanted speed."""
        limits = self._planner.limits
        faster = np.where(np.abs(wanted) > np.abs(self._v), wanted, self._v)
        stop = self._q + faster * 2 * LOOK_S + faster * np.abs(faster) / (2 * limits.acceleration)
        if np.any((stop < limits.low) & (faster < 0)) or np.any((stop > limits.high) & (faster > 0)):
            return False
        kept = self._planner.kept
        floor = kept.floor(kept.distances(self._q))
        ways = (self._q + share * (stop - self._q) for share in (0.5, 1.0))
        return not any(kept.entered(kept.distances(q), floor) for q in ways)

    def _stand_where_it_is(self) -> None:
        """Take the measured place for the reference; from there the arm may only move away."""
        limits, zones = self._planner.limits, self._planner.zones
        self._path, self._q = None, self._seen.copy()
        self._v = self._a = np.zeros_like(self._seen)
        outside = np.maximum(0.0, np.maximum(limits.low - self._seen, self._seen - limits.high))
        self._floor, self._outside = zones.floor(zones.distances(self._seen)), outside + OFF_RAD

    def _judge(self, measured: Joints) -> None:
        """Stop with a range error where the arm itself, not its reference, is where it must not be."""
        if self._mode == Mode.RANGE_ERROR or not self.busy:
            return
        zones, limits = self._planner.zones, self._planner.limits
        distances = zones.distances(measured)
        touch = zones.entered(distances + OFF_M, self._floor)
        outside = np.maximum(0.0, np.maximum(limits.low - measured, measured - limits.high))
        if touch is None and not np.any(outside > self._outside):
            self._floor = zones.raised(self._floor, distances)
            self._outside = np.minimum(self._outside, outside + OFF_RAD)
            return
        self.note = str(touch) if touch else self._planner.chain.broken_limit(measured)
        self.note = self.note.replace("°", " deg")
        self.hold()
        self._stand_where_it_is()  # rest here, do not push on
        self._end, self._mode = End.RANGE, Mode.RANGE_ERROR
        self._note("range_error", why=self.note)

    # what is told

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
        """Return what the gripper was told: 0 open, 1 closed."""
        return self._gripper

    @property
    def moving(self) -> bool:
        """Tell whether the set-point moves."""
        return self._path is not None or self._next is not None or self._wish is not None

    @property
    def busy(self) -> bool:
        """Tell whether the arm is at something."""
        return self.moving or self._mode == Mode.PROG_EXEC or self._ticks < self._gripped

    def letter(self) -> str:
        """Return the paper's answer to `w`: a awaiting, b busy, e error."""
        if self._mode == Mode.RANGE_ERROR:
            return "e"
        return "b" if self.busy else "a"

    def wait_for_rest(self, seconds: float) -> str:
        """Wait while the arm moves (`W`); return as `letter`."""
        until = time.monotonic() + seconds
        with self._rested:
            while self.busy and time.monotonic() < until:
                self._rested.wait(0.02)
        return self.letter()
