"""The owner's end of the brain: starts its process, feeds it, stores its newest answer, and restarts it.

The brain never sends a velocity. The wheels ask `fresh`, which returns None once the brain has been silent.
"""

import itertools
import logging
import threading
from collections.abc import Callable
from pathlib import Path

from robots.kit.clock import TIMER, Timer, Until
from robots.kit.contract.errors import HardwareFault
from robots.kit.drivers.irat.brain.child import Child, ChildProcess
from robots.kit.drivers.irat.brain.messages import Answer, Feed, FromBrain, Packet, Seen, ToBrain

log = logging.getLogger(__name__)
SILENT_S = 0.5  # after which nobody drives by its answers
STUCK_S = 60.0  # without an answer to a feed for so long it is killed and started again
ANSWER_S = 5.0
# real time, because a process starts and ends no faster on another clock:
AGAIN_S = 0.5
SAVED_S = 3.0  # within which it writes its map and ends
SILENT = "The robot's map does not answer."


class BrainProcess:
    """Thread safe. `packet` gets the byte streams' packets.

    `real` is the clock by which a process starts and ends, `child` makes one for a folder.
    """

    def __init__(
        self, folder: Path, packet: Callable[[Packet], None], clock: Timer = TIMER, real: Timer = TIMER,
        child: Callable[[Path], Child] = ChildProcess,
    ) -> None:  # fmt: skip
        self._folder, self._packet, self._clock, self._real = folder, packet, clock, real
        self._make, self._child = child, child(folder)
        self._aim: Callable[[int], ToBrain] | None = None
        self._reader: threading.Thread | None = None
        self._feeding, self._changed = threading.Lock(), threading.Condition()
        self._calls: dict[int, Answer | None] = {}
        self._numbers = itertools.count(1)
        self._closed = False
        self._fed_at: float | None = None  # when the feed was sent that is not answered yet
        self.newest: Seen | None = None
        self.heard_at = -1e9  # on its clock (s), of the newest answer to a feed
        self.starts = 0

    @property
    def pid(self) -> int:
        """Return the process's number."""
        return self._child.pid

    def start(self) -> None:
        """Start the process, unless it runs."""
        if self._reader is not None and self._reader.is_alive():
            return
        self._closed = False
        try:
            self._launch()
            self._reader = self._real.spawn(self._keep_running, "brain")
        except RuntimeError:  # the system has no thread left for now
            self.close()
            raise

    def _launch(self) -> None:
        with self._feeding:
            self._child, self._fed_at = self._make(self._folder), None
            self._child.begin()
        self.starts += 1

    def _keep_running(self) -> None:
        """Read its messages; start it again when it ends."""
        while True:
            for said in self._child.answers():
                self._take(said)
            if self._closed:
                return
            log.warning("the brain of the robot ended; it is started again")
            self._end()
            self._real.sleep(AGAIN_S)
            if self._closed:
                return
            try:
                self._launch()
            except (OSError, RuntimeError) as error:  # the system has no process or thread left for now
                log.warning("the brain of the robot cannot be started: %s", error)
                continue
            self._aim_again()

    def keep_aim(self, aim: Callable[[int], ToBrain] | None) -> None:
        """Send this aim again whenever the process was started again; None: nothing."""
        self._aim = aim

    def _aim_again(self) -> None:
        if self._aim is not None:
            self.post(self._aim(next(self._numbers)))

    def _take(self, said: FromBrain) -> None:
        if isinstance(said, Packet):
            try:
                self._packet(said)
            except Exception:  # a packet that cannot be handed on is no reason to end the brain
                log.exception("a packet of the stream %r was lost", said.stream)
            return
        with self._changed:
            if isinstance(said, Seen):
                self.newest, self.heard_at, self._fed_at = said, self._clock.monotonic(), None
            elif said.number in self._calls:
                self._calls[said.number] = said
            self._changed.notify_all()

    def post(self, message: ToBrain) -> None:
        """Send a message that has no answer. If it cannot be sent, it is lost."""
        self._child.send(message)

    def feed(self, feed: Feed) -> bool:
        """Send a step, unless the one before is not answered yet; tell whether it was sent."""
        now = self._clock.monotonic()
        if self._fed_at is not None:
            if now - self._fed_at > STUCK_S:
                self._child.kill()
            return False
        with self._feeding:
            self._fed_at = now
            self.post(feed)
        return True

    def call(self, make: Callable[[int], ToBrain], seconds: float = ANSWER_S) -> Answer:
        """Send a numbered message, and return its answer. Raises HardwareFault if there is none."""
        number = next(self._numbers)
        with self._changed:
            self._calls[number] = None
        self.post(make(number))
        with self._changed:
            self._clock.wait(Until(self._changed, lambda: self._calls[number] is not None), seconds)
            answer = self._calls.pop(number)
        if answer is None:
            raise HardwareFault(SILENT)
        return answer

    def fresh(self, seconds: float = SILENT_S) -> Seen | None:
        """Return its newest answer, None if it has been silent for so long."""
        with self._changed:
            return self.newest if self._clock.monotonic() - self.heard_at <= seconds else None

    def wait(self, after: float, seconds: float) -> Seen | None:
        """Return an answer that came after a time (of its clock, s); None if there is none in so many real seconds."""
        with self._changed:  # real time: the process starts no faster on another clock
            self._real.wait(Until(self._changed, lambda: self.heard_at > after), seconds)
            return self.newest if self.heard_at > after else None

    def close(self) -> None:
        """End the process. Never raises."""
        self._closed = True
        self._end()
        if self._reader is not None and self._reader is not threading.current_thread():
            self._reader.join(2.0)
        self._reader = None

    def _end(self) -> None:
        self.heard_at = -1e9
        self._child.end(SAVED_S)
