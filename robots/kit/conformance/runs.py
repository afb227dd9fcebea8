"""One command that a driver carries out in a thread, with its calls of `permit` and `on_stage`."""

import threading
from collections.abc import Callable, Mapping
from typing import TypeVar

from robots.kit.clock import Timer
from robots.kit.contract.errors import NotPermitted, Stopped
from robots.kit.contract.session import JSON, Outcome, Report, Session

T = TypeVar("T")
SENT, ACKNOWLEDGED = "sent", "acknowledged"


class Call:
    """A function that is called in a thread of its own; `over` is set once it has returned or raised."""

    def __init__(self, clock: Timer, function: Callable[[], object], name: str) -> None:
        self._clock, self._function = clock, function
        self.over = threading.Event()
        self.late = False  # it did not end within the time of `ends`
        self.value: object = None
        self.error: BaseException | None = None
        clock.spawn(self._run, f"conformance {name}")

    def _run(self) -> None:
        try:
            self.value = self._function()
        except BaseException as error:  # noqa: BLE001 - whatever it is, the suite judges it
            self.error = error
        finally:
            self.over.set()

    def ends(self, seconds: float) -> bool:
        """Wait until it has ended, for at most so many seconds of the clock; tell whether it has."""
        ended = self._clock.wait(self.over, seconds)
        self.late = self.late or not ended
        return ended


class Run(Call):
    """A command of a session.

    Its permit raises `refuse` unless that is None; it may be set while the command runs. `at`: the functions that are
    called, in the command's own thread, when a stage of that name is told.
    """

    def __init__(
        self, session: Session, clock: Timer, kind: str, args: JSON, refuse: BaseException | None = None,
        at: Mapping[str, Callable[[], object]] | None = None,
    ) -> None:  # fmt: skip
        self.kind, self.args, self.refuse, self._at = kind, args, refuse, dict(at or {})
        self.stages: list[Report] = []
        self.permits = self.permits_at_sent = self.permits_on_way = 0
        self.refused = threading.Event()  # the permit has raised
        self.acknowledged = threading.Event()
        super().__init__(clock, lambda: session.execute(kind, dict(args), self._permit, self._told), kind)

    def _permit(self) -> None:
        self.permits += 1
        self.permits_on_way += self.acknowledged.is_set()
        if self.refuse is not None:
            self.refused.set()
            raise self.refuse

    def _told(self, stage: Report) -> None:
        if stage == SENT and SENT not in self.stages:
            self.permits_at_sent = self.permits
        self.stages.append(stage)
        then = self._at.pop(stage, None) if isinstance(stage, str) else None
        if then is not None:
            then()
        if stage == ACKNOWLEDGED:
            self.acknowledged.set()

    def has_begun(self) -> bool:
        """Tell whether the robot has understood the command, or the command has ended."""
        return self.acknowledged.is_set() or self.over.is_set()

    @property
    def outcome(self) -> Outcome | None:
        """Return what the driver returned, if it is an outcome."""
        return self.value if isinstance(self.value, Outcome) else None

    def named_stages(self) -> list[str]:
        """Return the stages without the progress."""
        return [stage for stage in self.stages if isinstance(stage, str)]


def denial() -> NotPermitted:
    """Return an error as a permit raises it when the robot is stopped; the driver has to let this very one through."""
    return Stopped("The conformance suite gives no permit.")


def command_text(kind: str, args: Mapping[str, object]) -> str:
    """Return a command in words, as `turn(angle=1.0)`."""
    return f"{kind}({', '.join(f'{name}={_short(value)}' for name, value in args.items())})"


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 24 else f"{text[:20]}..."


def error_text(error: BaseException | None) -> str:
    """Return an error in words."""
    return "no error" if error is None else f"{type(error).__name__} ({str(error)[:120]})"
