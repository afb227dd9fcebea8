"""The dead-man timer of a held motion.

A held motion begins only if its operator's controls were heard within the last `SILENT_S`, however long it waited
behind another, and were not released. It goes on while keep-alives arrive. It ends when the controls are released,
when no keep-alive came for `SILENT_S`, or at its longest duration. Once silence has ended it, it stays ended: the robot
is held by then, and a late keep-alive must not move it again.

A keep-alive may carry newer values of a motion that is steered; the latest wins. One whose values are refused counts
for nothing: the motion goes on at the values before, and ends if only such keep-alives come.
"""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf
from types import MappingProxyType
from typing import Any

from robots.kit.clock import Clock
from robots.kit.contract.errors import ControlsReleased
from robots.models import Command
from robots.services import START_S

SILENT_S = 0.25  # together with the braking of one short step this is half a second to rest
Values = Mapping[str, Any]
Judge = Callable[[dict[str, Any]], bool]  # whether a keep-alive may carry these values
LOOK_S = 0.005  # between two looks for the first keep-alive


@dataclass
class DeadManTimer:
    """The timer of the held motion that runs: the key of its command, the time of its last keep-alive. Thread safe."""

    clock: Clock
    _runs: int | None = None
    _until: float = 0.0
    _heard: float = -inf
    _released: bool = False
    _steered: dict[str, Any] = field(default_factory=dict)  # the newest values of the motion that runs
    _judge: Judge = lambda args: False
    _waiting: dict[int, float] = field(default_factory=dict)  # last keep-alives of motions that do not run
    _let_go: dict[int, float] = field(default_factory=dict)  # when their controls were released

    def __post_init__(self) -> None:
        """Create the lock."""
        self._lock = threading.Lock()

    def start(self, command: Command, judge: Judge = lambda args: False) -> None:
        """Watch over `command` from now on; `judge` says which values its keep-alives may carry.

        Its first keep-alive, which its press sends, may still be on its way: this waits for it, at most `SILENT_S`.
        """
        which = command.pk
        latest = self.clock.monotonic() + SILENT_S
        while (now := self.clock.monotonic()) < latest and not self._heard_of(which, now):
            self.clock.sleep(LOOK_S)
        with self._lock:
            self._forget(now)
            self._runs, self._until = which, now + command.limit_s
            self._heard, self._released = self._waiting.pop(which, -inf), which in self._let_go
            self._steered, self._judge = {}, judge

    def _heard_of(self, which: int, now: float) -> bool:
        return now - self._waiting.get(which, -inf) <= SILENT_S or which in self._let_go

    def _forget(self, now: float) -> None:
        """Forget what was heard of motions that are over, or never began."""
        for words in (self._waiting, self._let_go):
            for which in [which for which, at in words.items() if now - at > START_S]:
                del words[which]

    def end(self) -> None:
        """Note that no held motion runs any more."""
        with self._lock:
            if self._runs is not None:
                self._let_go.pop(self._runs, None)
            self._runs = None

    def hear(self, which: int, held: bool, args: Values = MappingProxyType({})) -> None:
        """Note a keep-alive (`held`) of a command, or that its controls were released; `args`: its newer values."""
        if held and args and which == self._runs and not self._judge(dict(args)):
            return
        now = self.clock.monotonic()
        with self._lock:
            self._forget(now)
            if not held:
                self._let_go[which] = now
                self._released = self._released or which == self._runs
            elif which != self._runs:
                self._waiting[which] = now
            elif now - self._heard <= SILENT_S:
                self._heard = now
                self._steered = {**self._steered, **args}

    @property
    def steered(self) -> dict[str, Any]:
        """Return the newest values that keep-alives of the running motion have carried."""
        with self._lock:
            return dict(self._steered) if self._runs is not None else {}

    @property
    def end_reason(self) -> str:
        """Return why the held motion has to end: released, lost or long; empty while it may go on."""
        with self._lock:
            if self._runs is None:
                return ""
            now = self.clock.monotonic()
            if self._released:
                return "released"
            if now - self._heard > SILENT_S:
                return "lost"
            return "long" if now >= self._until else ""

    def check(self) -> None:
        """Return if the held motion may go on. Raises ControlsReleased."""
        if self.end_reason:
            raise ControlsReleased("The controls were released.")
