"""A world in which time is virtual: real threads, one at a time, in an order that a seed decides.

A thread gives the processor away only where it waits: for time, an event, a lock, a wire, the bus; and before a statement
outside a transaction. When every thread waits, the clock jumps to the next time that one of them waits for. So a run
depends on its seed alone, however fast the machine is, and however busy.
"""

import hashlib
import math
import random
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta

from django.db import OperationalError, connections

from robots.kit.clock import Until, Waitable
from tests.world.delays import NONE, Delays

BEGIN = datetime(2026, 1, 1, tzinfo=UTC)
BEGIN_S = 1000.0  # the monotonic clock at that time


class Killed(KeyboardInterrupt):
    """Raised in what is left of a killed thread when its world closes; whatever it does then reaches nobody."""


class Everlasting(AssertionError):
    """Every thread waits for ever."""


class DatabaseAway(OperationalError):
    """The database does not answer, because the test has taken it away."""


class Process:
    """A process of the world: threads that are frozen and killed together."""

    def __init__(self, name: str, number: int) -> None:
        self.name, self.number = name, number
        self.killed = self.frozen = False
        self.delayed = True  # whether its threads may be late
        self.judges = False  # whether the database never goes away from it
        self.at_kill: list[Callable[[], object]] = []  # called when it dies, as the kernel closes files
        self.moment: tuple[int, Callable[[], object]] | None = None  # see `World.at_moment`


class Thread(threading.Thread):
    """A thread of the world; it runs while the world has passed it the turn to run."""

    def __init__(self, world: "World", process: Process, run: Callable[[], object], name: str) -> None:
        super().__init__(name=name, daemon=True)
        self.world, self.process, self.body = world, process, run
        self.turn = threading.Lock()
        self.turn.acquire()
        self.due, self.holds = world.monotonic(), None
        self.late_s, self.ready_at = 0.0, None
        self.over = False
        self.database = connections["default"]  # of this thread once it runs: a look costs more than a choice

    def run(self) -> None:
        self.turn.acquire()
        self.database = connections["default"]
        try:
            with self.world.at_statements():
                self.world.check_alive()
                self.body()
        except Killed:
            pass
        except BaseException as error:
            traceback.print_exc()
            self.world.errors.append((self.name, error))
        finally:
            self.over = True
            connections.close_all()
            self.world.leave(self)

    def join(self, timeout: float | None = None) -> None:
        world = self.world
        if threading.current_thread() in (world.running, world.main):
            world.park(math.inf if timeout is None else world.monotonic() + timeout, lambda: self.over)
        else:
            super().join(timeout)

    def is_alive(self) -> bool:
        return not self.over and not self.process.killed


class World:
    """Clock, threads, locks and processes of one run. It is a `robots.kit.clock.Clock`."""

    def __init__(self, seed: int, delays: Delays = NONE) -> None:
        self.seed, self.delays = seed, delays
        self._choice = random.Random(f"choice {seed}")
        self._t, self._slept, self._set_by = BEGIN_S, 0.0, timedelta(0)
        self.waits = self.switches = 0
        self._history = hashlib.sha256()
        self.errors: list[tuple[str, BaseException]] = []
        self.closed = self._stuck = False
        self.database_away = False  # for every process but those that judge
        self.named_after_s = 30.0  # of real time
        self.host = Process("the test", 1)
        self.host.delayed, self.host.judges = False, True
        self.threads: list[Thread] = []
        self.processes = {self.host.number: self.host}
        self.main = threading.current_thread()  # the test's
        self.running = Thread(self, self.host, lambda: None, "the test")
        self.threads.append(self.running)

    # clock

    def monotonic(self) -> float:
        return self._t

    def awake(self) -> float:
        return self._t - self._slept

    def now(self) -> datetime:
        return BEGIN + timedelta(seconds=self._t - BEGIN_S) + self._set_by

    def step(self, seconds: float) -> None:
        """Set the time of day by so many seconds."""
        self._set_by += timedelta(seconds=seconds)
        self.note(f"the time of day was set by {seconds:g} s")

    def suspend(self, seconds: float) -> None:
        """Let the whole machine sleep so long."""
        self.note(f"the machine slept {seconds:g} s")
        self._t += seconds
        self._slept += seconds

    def sleep(self, seconds: float) -> None:
        self.park(self._t + max(0.0, seconds))

    def wait(self, what: Waitable, seconds: float) -> bool:
        due = self._t + max(0.0, seconds)
        if isinstance(what, threading.Event):
            return self.park(due, what.is_set)
        if not isinstance(what, Until):
            return self.park(due, lambda: what.wait(0))
        what.changed.release()
        try:
            return self.park(due, what.holds)
        finally:
            what.changed.acquire()

    # threads

    def process(self, name: str, delayed: bool = True) -> Process:
        """Begin a process; `inside` it its first thread is spawned."""
        made = Process(name, len(self.processes) + 1)
        made.delayed = delayed
        self.processes[made.number] = made
        return made

    def spawn(self, run: Callable[[], object], name: str, process: Process | None = None) -> Thread:
        """Start a thread, in the process of the thread that calls unless another is named."""
        self.check_alive()
        thread = Thread(self, process or self.running.process, run, name)
        self.threads.append(thread)
        thread.start()
        return thread

    def lock(self) -> "Lock":
        return Lock(self)

    def freeze(self, process: Process) -> None:
        """Stop a process as SIGSTOP does; `thaw` lets it go on."""
        self.note(f"{process.name} was frozen")
        process.frozen = True

    def thaw(self, process: Process) -> None:
        self.note(f"{process.name} goes on")
        process.frozen = False

    def kill(self, process: Process) -> None:
        """End a process as SIGKILL does: nothing of it runs any more, no `finally` either, and its files are closed."""
        if process.killed:
            return
        self.note(f"{process.name} was killed")
        process.killed = True
        for close in process.at_kill:
            close()
        if self.running.process is process:
            self._switch(self.running)

    def at_moment(self, process: Process, number: int, do: Callable[[], object]) -> None:
        """Call `do` before the process waits, or asks the database outside a transaction, for the nth time from now.

        Where no time passes, a death at a drawn time comes hardly ever: between a claim and what is sent for it.
        """
        process.moment = number, do

    def _count(self, process: Process) -> None:
        if process.moment is None:
            return
        left, do = process.moment
        process.moment = (left - 1, do) if left > 1 else None
        if left <= 1:
            do()

    def check_alive(self) -> None:
        if self.closed and self.running is not self.threads[0]:
            raise Killed

    # scheduler

    def park(self, due: float, holds: Callable[[], object] | None = None) -> bool:
        """Wait until `due` (monotonic, s) or until it `holds`; tell whether it does."""
        me = self._here()
        self.check_alive()
        if me.database.in_atomic_block:
            raise AssertionError(f"{me.name!r} waits inside a transaction, which keeps everybody from the database")
        self._count(me.process)
        self.waits += 1
        me.due, me.holds = due, holds
        me.late_s = self.delays.of(self.waits) if me.process.delayed else 0.0
        while True:
            me.ready_at = None
            self._switch(me)
            if self._stuck and me is self.threads[0]:
                self._stuck = False
                raise Everlasting(f"everybody waits for ever: {sorted(t.name for t in self.threads)}")
            came = bool(holds and holds())
            if came or self._t >= due:
                return came
            me.late_s = 0.0  # its condition no longer held when it came back

    def _here(self) -> Thread:
        """Return the thread that runs. Fails in a thread that is none of this world's."""
        me, here = self.running, threading.current_thread()
        if here is not me and not (me is self.threads[0] and here is self.main):
            raise AssertionError(f"the thread {here.name!r} waits in a world to which it does not belong")
        return me

    def pause(self, seconds: float) -> None:
        """Let a call to another process take so long, unless a transaction is open: nobody waits inside one."""
        if not self.running.database.in_atomic_block:
            self.sleep(seconds)

    def yield_(self) -> None:
        """Let another thread run first, if the seed says so."""
        if self._choice.random() < 0.25:
            self.park(self._t, None)

    def _switch(self, me: Thread) -> None:
        chosen = self._next()
        if chosen is me:
            return
        self.switches += 1
        self.running = chosen
        chosen.turn.release()
        while not me.turn.acquire(timeout=self.named_after_s if me is self.threads[0] else -1):
            self._name_the_running()
        self.check_alive()

    def _name_the_running(self) -> None:
        """Say who keeps all others from running, and where it is: it waits outside the world, or computes for long."""
        running = self.running
        frame = sys._current_frames().get(running.ident)
        stack = "".join(traceback.format_stack(frame)) if frame else ""
        sys.stderr.write(f"{running.name!r} has not given way for {self.named_after_s:g} s of real time:\n{stack}")

    def leave(self, me: Thread) -> None:
        """Pass the turn on; the thread has ended."""
        self.threads.remove(me)
        if self.closed:
            return
        self.running = self._next()
        self.running.turn.release()

    def _next(self) -> Thread:
        """Choose who runs; where nobody is able to, let time pass.

        A thread may run once its time is up, or what it waits for holds, and it is not late.
        """
        while True:
            now, soonest, able = self._t, math.inf, []
            for thread in self.threads:
                if thread.process.frozen or thread.process.killed:
                    continue
                if thread.ready_at is None and (now >= thread.due or (thread.holds and thread.holds())):
                    thread.ready_at = min(now, thread.due)
                at = (thread.due if thread.ready_at is None else thread.ready_at) + thread.late_s
                if at <= now:
                    able.append(thread)
                elif at < soonest:
                    soonest = at
            if able:
                chosen = able[0] if len(able) == 1 else self._choice.choice(able)
                self._history.update(f"{now:.6f} {chosen.name};".encode())
                return chosen
            if math.isinf(soonest):
                self._stuck = True
                return self.threads[0]
            self._t = soonest

    # statements

    @contextmanager
    def at_statements(self) -> Iterator[None]:
        """Let other threads run before the statements of this thread that stand outside a transaction."""

        def before(execute, sql, params, many, context):
            self.check_alive()
            if not context["connection"].in_atomic_block:
                self._count(self.running.process)
                if self.running.process.frozen:
                    self.park(self._t)
                self.yield_()
            if self.database_away and not self.running.process.judges:
                raise DatabaseAway("the database is away")
            return execute(sql, params, many, context)

        with connections["default"].execute_wrapper(before):
            yield

    # history

    def note(self, text: str) -> None:
        """Write something that happened into the history, by which two runs are compared."""
        self._history.update(f"{self._t:.6f} {text};".encode())

    @property
    def history(self) -> str:
        """Return a digest of who ran when, and of all that was noted."""
        return self._history.hexdigest()[:16]

    def until(self, holds: Callable[[], object], seconds: float, what: str) -> object:
        """Wait until it holds; fail after so many seconds. It looks each 10 ms at first, less and less often later."""
        begun = self._t
        while not (value := holds()):
            self.check_errors()
            assert self._t < begun + seconds, f"{what}: not within {seconds:g} s"
            self.sleep(min(0.01 + 0.05 * max(0.0, self._t - begun - 0.5), 0.25))
        return value

    def check_errors(self) -> None:
        """Fail if a thread died of an error."""
        if self.errors:
            name, error = self.errors[0]
            raise AssertionError(f"the thread {name!r} died: {error!r}") from error

    def close(self) -> None:
        """End every thread, one after another; nothing that they still do is seen by anybody."""
        self.closed = True
        for thread in self.threads[1:]:
            self.running = thread
            thread.turn.release()
            threading.Thread.join(thread, 10)
            if threading.Thread.is_alive(thread):
                frame = sys._current_frames().get(thread.ident)
                stack = "".join(traceback.format_stack(frame)) if frame else ""
                raise AssertionError(f"the thread {thread.name!r} does not end with its world:\n{stack}")
        self.running = self.threads[0]


class Lock:
    """A reentrant lock for which threads of the world wait."""

    def __init__(self, world: World) -> None:
        self._world, self._owner, self._times = world, None, 0

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        world = self._world
        if world.closed:
            return True
        me = world.running
        if self._owner not in (None, me):
            if not blocking:
                return False
            due = math.inf if timeout < 0 else world.monotonic() + timeout
            if not world.park(due, lambda: self._owner is None):
                return False
        self._owner, self._times = me, self._times + 1
        return True

    def release(self) -> None:
        self._times -= 1
        if self._times <= 0:
            self._owner = None

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()
