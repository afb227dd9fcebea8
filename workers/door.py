"""Between the owner and what others wrote: drivers, cameras and their libraries. Whatever they raise is a sentence."""

import logging
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

from robots.kit.clock import TIMER, Timer
from robots.kit.contract.errors import HardwareFault, RobotError, why
from robots.kit.contract.session import JSON, OnStage, Outcome, Permit, RobotState, Session

log = logging.getLogger(__name__)
T = TypeVar("T")


class DriverFailed(HardwareFault):
    """The driver raised something that is no sentence for people."""


class Door:
    """Turns whatever is raised inside into `fault`, a sentence that begins with `words`; its owner tries again later.

    Every built-in exception counts, SystemExit too; only Ctrl-C passes. The traceback goes into the log once, until
    another error follows or it has worked: pictures and states may fail many times a second.
    """

    def __init__(self, fault: type[RobotError], words: str) -> None:
        self._fault, self._words = fault, words
        self._logged: type[BaseException] | None = None

    @contextmanager
    def open(self, *passes: type[BaseException], ours: "Ours | None" = None) -> Iterator[None]:
        """Let errors of the types `passes`, and those that `ours` has raised, through as they are."""
        try:
            yield
            self._logged = None
        except BaseException as error:
            if isinstance(error, (KeyboardInterrupt, *passes)) or (ours is not None and error is ours.raised):
                raise
            name, told = type(error).__name__, why(error)
            text = f"{self._words}: {name if told == name else f'{name}: {told}'}."
            if type(error) is not self._logged:
                log.warning(text, exc_info=error)
            self._logged = type(error)
            raise self._fault(text) from error


class Ours:
    """Functions of the owner that a driver calls; `raised` is what the last one that failed has raised."""

    def __init__(self) -> None:
        self.raised: BaseException | None = None

    def of(self, function: Callable[..., T]) -> Callable[..., T]:
        """Return the function, whose errors are remembered."""

        def called(*args: Any) -> T:
            try:
                return function(*args)
            except BaseException as error:
                self.raised = error
                raise

        return called


class GuardedSession(Session):
    """A driver's session behind a door: `connect`, `state` and `hold` raise HardwareFault and nothing else.

    A driver that cannot even be made, or cannot connect for an error without a sentence, is made anew. One that fails
    in the middle of a command is held.
    """

    def __init__(self, make: Callable[[], Session]) -> None:
        self._make, self._door = make, Door(DriverFailed, "The robot's driver failed")
        self._making = threading.Lock()
        self._session: Session | None = None
        with suppress(HardwareFault):  # `connect` says it
            self._made()

    def _made(self) -> Session:
        with self._making:
            if self._session is None:
                with self._door.open(HardwareFault):
                    self._session = self._make()
            return self._session

    @property
    def clock(self) -> Timer:  # type: ignore[override]
        """The clock by which the driver's states are stamped."""
        return getattr(self._session, "clock", TIMER)

    @property
    def line(self) -> Any:
        """The driver's line, which counts resent and broken frames; None if it has none."""
        return getattr(self._session, "line", None)

    def connect(self) -> RobotState:
        """Open the wire and ask the hardware for its state. Raises HardwareFault."""
        session = self._made()
        try:
            with self._door.open(HardwareFault):
                return _of_type(RobotState, session.connect())
        except DriverFailed:
            self.close()  # what it was in the middle of is not known
            with self._making:
                self._session = None
            raise

    def state(self) -> RobotState:
        """Ask the hardware. Raises HardwareFault."""
        session = self._made()
        with self._door.open(HardwareFault):
            return _of_type(RobotState, session.state())

    def execute(self, kind: str, args: JSON, permit: Permit, on_stage: OnStage) -> Outcome:
        """Carry out a command and wait for its end. Raises as the driver's, but for errors that have no sentence."""
        session, ours = self._made(), Ours()
        with self._held(ours):
            return _of_type(Outcome, session.execute(kind, args, ours.of(permit), ours.of(on_stage)))

    def recover(self, permit: Permit) -> RobotState:
        """Reset after a fault. Raises as the driver's, but for errors that have no sentence."""
        session, ours = self._made(), Ours()
        with self._held(ours):
            return _of_type(RobotState, session.recover(ours.of(permit)))

    @contextmanager
    def _held(self, ours: Ours) -> Iterator[None]:
        """Hold the robot where its driver fails without a sentence: it may be in motion."""
        try:
            with self._door.open(RobotError, ours=ours):
                yield
        except DriverFailed as error:
            try:
                self.hold()
            except HardwareFault:
                raise DriverFailed(f"{error} The robot could not be held: look at it.") from error
            raise DriverFailed(f"{error} The robot was held.") from error

    def hold(self) -> RobotState:
        """Bring the robot to rest now; any thread. Raises HardwareFault where that is not certain."""
        session = self._made()
        with self._door.open(HardwareFault):
            return _of_type(RobotState, session.hold())

    def close(self) -> None:
        """Release the wire. Never raises."""
        with suppress(HardwareFault), self._door.open():
            if self._session is not None:
                self._session.close()

    def picture(self, view: str, seconds: float) -> bytes | None:
        """Return a picture that comes over the robot's own wire. Raises HardwareFault."""
        session = self._made()
        with self._door.open(HardwareFault):
            return session.picture(view, seconds)

    def rests_within(self) -> float | None:
        """Return within how many seconds the robot rests without a word. Raises HardwareFault."""
        session = self._made()
        with self._door.open(HardwareFault):
            return session.rests_within()

    def latest(self) -> RobotState | None:
        """Return the newest state that was kept, without asking the hardware."""
        session = self._session
        if session is None:
            return None
        try:
            with self._door.open(HardwareFault):
                return session.latest()
        except HardwareFault:
            return None


def _of_type(kind: type[T], value: object) -> T:
    if not isinstance(value, kind):
        raise TypeError(f"it returned {type(value).__name__} instead of {kind.__name__}")
    return value
