"""The state that all checks share: the session under test, its clock, the limits, and the observations so far."""

import math
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from robots.kit.clock import Limit, Timer, poll
from robots.kit.conformance.runs import Call, Run, error_text
from robots.kit.conformance.streams import Recorder
from robots.kit.contract.errors import HardwareFault, LineSilent, RobotError
from robots.kit.contract.session import JSON, RobotState, Session
from robots.kit.contract.spec import CommandKind, Spec

Opening = Callable[[], Session]
PAUSE_S = 0.02  # between two looks
AGAIN_S = 1.0  # between two attempts to connect
ENDLESS = 1e6  # s, counts as the length of a motion that does not end by itself while it is watched


@dataclass(frozen=True)
class Limits:
    """The longest waits of the suite, in seconds of the session's clock; none of them judges how fast a robot is.

    `answer_s`: for a call that moves nothing, and for a hold. `opens_s`: for so long `connect` is called again after a
    fault, as the owner does, because the controller may boot. `watch_s`: a motion is watched for so long, then held,
    because a patrol has no end. `beyond_s`: after its own limit, until a motion counts as endless. `age_s`: of a state
    that was just requested.
    """

    answer_s: float = 60.0
    opens_s: float = 30.0
    watch_s: float = 15.0
    beyond_s: float = 60.0
    age_s: float = 10.0


class Faults(Protocol):
    """The fault board of a simulator (`docs/how-to/inject-faults.md`)."""

    def set(self, verb: str, value: float = 1.0, count: int | None = None) -> bool:
        """Switch a fault on; tell whether the board took it."""

    def clear(self) -> None:
        """Switch all faults off."""

    def motions(self) -> int | None:
        """Return how many motions the simulator has counted; None where it does not count them."""

    def moving(self) -> bool | None:
        """Tell whether the simulated robot moves; None where the simulator does not tell it."""

    def boots(self) -> int | None:
        """Return the number of the controller's present start; None where the simulator does not tell it."""


def _no_board() -> None:
    return None


class Broken(Exception):
    """The robot cannot be made ready; the text says why."""


@dataclass
class Trial:
    """One robot under test. `examples` are values with which kinds of commands can be carried out.

    `nowhere` makes a session whose address leads nowhere, `pictures` are the addresses of cameras by view.
    """

    opening: Opening
    spec: Spec
    clock: Timer
    limits: Limits = field(default_factory=Limits)
    name: str = ""
    description: Mapping[str, Any] = field(default_factory=dict)
    examples: Mapping[str, Sequence[JSON]] = field(default_factory=dict)
    board: Callable[[], Faults | None] = _no_board
    nowhere: Opening | None = None
    pictures: Callable[[], Mapping[str, str]] = dict

    def __post_init__(self) -> None:
        """Prepare; nothing is opened."""
        self.recorder = Recorder(self.spec)
        self.before = {thread.ident for thread in threading.enumerate()}
        self.children = children()
        self.session: Session | None = None
        self.runs: list[Run] = []
        self.moved: dict[str, float] = {}  # for how long (s) each kind was seen moving
        self.states: dict[str, RobotState] = {}  # the last state seen in a motion of each kind

    @property
    def faults(self) -> Faults | None:
        """Return the fault board; it may appear some time after the line of a simulator."""
        return self.board()

    def motions(self) -> tuple[CommandKind, ...]:
        """Return the kinds that move the robot."""
        return tuple(c for c in self.spec.commands if c.lane == "motion" and c.moves)

    def ready_session(self) -> Session:
        """Return a session that is connected and whose robot is ready. Raises Broken."""
        if self.session is None:
            self.session = self.opening()
            self.recorder.again()
            self.session.on_packet = self.recorder.take
            self.connected(self.session)
        state = self.state_from(self.session.state, "state")
        if state.moving:
            self.state_from(self.session.hold, "hold")
        if not state.ready or state.fault:
            state = self.state_from(lambda: self.opened_session().recover(lambda: None), "recover")
        if not state.ready:
            raise Broken(f"The robot is not ready after recover(): {state.fault or 'it does not say why'}.")
        return self.session

    def connected(self, session: Session) -> RobotState:
        """Connect, again and again where the hardware is not ready for it. Raises Broken."""
        limit = Limit(self.clock, self.limits.opens_s)
        while True:
            call = Call(self.clock, session.connect, "connect")
            if not call.ends(self.limits.answer_s) or not isinstance(call.error, HardwareFault) or limit.over:
                return self.state_of(call, "connect")
            if not isinstance(call.error, LineSilent):
                session.close()
            self.clock.sleep(AGAIN_S)

    def opened_session(self) -> Session:
        """Return the open session. Raises Broken if there is none."""
        if self.session is None:
            raise Broken("There is no session.")
        return self.session

    def state_from(self, function: Callable[[], object], name: str) -> RobotState:
        """Return the state that a method of the session returns. Raises Broken for anything else."""
        return self.state_of(Call(self.clock, function, name), name)

    def state_of(self, call: Call, name: str) -> RobotState:
        """Return the state that a call returns. Raises Broken for anything else."""
        if not call.ends(self.limits.answer_s + self.limits.beyond_s):
            raise Broken(f"{name}() did not return.")
        if call.error is not None:
            raise Broken(f"{name}() raised {error_text(call.error)}.")
        if not isinstance(call.value, RobotState):
            raise Broken(f"{name}() returned {type(call.value).__name__} instead of a RobotState.")
        return call.value

    def settle(self) -> None:
        """End what still runs and bring the robot to rest, on a new session if this one is lost. Raises Broken."""
        if self.faults is not None:
            self.faults.clear()
        going = [run for run in self.runs if not run.over.is_set()]
        for run in going:
            run.refuse = run.refuse or HardwareFault("The conformance suite is over.")
            if self.session is not None:
                Call(self.clock, self.session.hold, "hold").ends(self.limits.answer_s)
            if not run.ends(self.limits.answer_s):
                raise Broken(f"execute({run.kind!r}) did not end after a hold, and its permit was refused.")
        self.runs.clear()
        try:
            self.ready_session()
        except Broken:
            self.close()
            self.ready_session()

    def close(self) -> None:
        """Close the session, if there is one."""
        session, self.session = self.session, None
        if session is not None:
            Call(self.clock, session.close, "close").ends(self.limits.answer_s)

    def run(
        self, kind: str, args: JSON, refuse: BaseException | None = None,
        at: Mapping[str, Callable[[], object]] | None = None,
    ) -> Run:  # fmt: skip
        """Begin a command."""
        run = Run(self.opened_session(), self.clock, kind, args, refuse, at)
        self.runs.append(run)
        return run

    def call(self, function: Callable[[], object], name: str) -> Call:
        """Call a method of the session in a thread of its own."""
        return Call(self.clock, function, name)

    def poll(self, holds: Callable[[], object], seconds: float) -> bool:
        """Check again and again whether `holds` is true, for at most so many seconds."""
        return poll(holds, self.clock, seconds, PAUSE_S)

    def looks(self, run: Run, seconds: float) -> Iterator[RobotState]:
        """Yield states while a command runs, for at most so many seconds; nothing of a robot that does not answer."""
        session, until, again = self.opened_session(), self.clock.monotonic() + seconds, True
        while again:  # at least once, however long the machine stalls
            again = not run.over.is_set() and self.clock.monotonic() < until
            try:
                state = session.state()
            except RobotError:
                self.clock.sleep(PAUSE_S)
                continue
            if state.moving:
                self.states[run.kind] = state
            yield state
            self.clock.sleep(PAUSE_S)

    def motion_count(self) -> int | None:
        """Return how many motions the simulator has counted; None where nothing counts them."""
        board = self.faults
        return None if board is None else board.motions()

    def counted_since(self, counted: int | None) -> bool:
        """Tell whether the simulator has counted another motion since."""
        return counted is not None and self.motion_count() not in (None, counted)

    def limit_of(self, kind: str) -> float:
        """Return after how many seconds a command of that kind counts as never ending."""
        found = self.spec.command(kind)
        return (found.limit_s if found else 0.0) + self.limits.beyond_s


def children() -> frozenset[int]:
    """Return the processes that this one has started and that still run; none where the system does not tell."""
    found: set[str] = set()
    for file in Path("/proc/self/task").glob("*/children"):
        with suppress(FileNotFoundError, ProcessLookupError):  # the thread has ended meanwhile
            found.update(file.read_text().split())
    return frozenset(map(int, found))


def apart(one: Sequence[float], other: Sequence[float]) -> float:
    """Return the greatest distance between the numbers of two states; infinite where they have not the same ones."""
    if len(one) != len(other):
        return math.inf
    return max((abs(a - b) for a, b in zip(one, other, strict=True)), default=0.0)
