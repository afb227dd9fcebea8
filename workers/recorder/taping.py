"""One recording while it runs: takes packets from the bus and writes them in a thread of its own.

What the disk cannot take in time is left out and counted, pictures first; who puts never waits.
"""

import contextlib
import logging
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Any

from robots.kit.contract.spec import Spec
from robots.kit.contract.streams import unpack
from robots.kit.packets import PICTURE_HEAD
from robots.kit.recording.budget import picture_every_s
from robots.kit.recording.container import CAMERA, COMMANDS, EVENTS, STATE, STREAM, Message, Tape
from robots.kit.recording.packets import picture_of, state_told
from robots.kit.recording.reading import messages

log = logging.getLogger(__name__)
FLUSH_S = 2.0  # a recorder that is killed loses no more
PICTURES_WAIT, ALL_WAIT = 4_000_000, 8_000_000  # bytes that may wait for the disk
AWAY_NS = 3600 * 10**9  # longer than a recorder is away while a turn goes on: else the time of day was set
EARLY_NS = 20_000_000  # a picture may come so much before its time
TOO_LARGE = "It reached the greatest size of a recording."
NO_ROOM = "The server's disk had no room for more."
FAILED = "It could not be written: {}."


@dataclass
class End:
    """The end of a recording: whole, or cut short for a reason; and how much was left out."""

    whole: bool = True
    reason: str = ""
    dropped: int = 0


@dataclass
class _Queue:
    """The messages that wait for the disk."""

    items: deque[tuple[str, int, bytes]] = field(default_factory=deque)
    size: int = 0
    dropped: int = 0


class Taping:
    """Writes one recording. Public methods are called by the recorder's thread; `written` is set at the end."""

    def __init__(
        self, path: Path, about: dict[str, str], spec: Spec, cameras: int, limit: int, room: Callable[[], bool]
    ) -> None:
        self._path, self._live = path, path.with_suffix(".tape")
        self._about, self._limit, self._room, self._cameras = about, limit, room, cameras
        self._coordinates = len(spec.carried())
        self._joints, self._channels = spec.joints, [channel.name for channel in spec.packed()]
        self._streams = [stream.name for stream in spec.streams]
        self._queue = _Queue()
        self._news = threading.Condition()
        self._closing = False
        self._pictured: dict[int, int] = {}  # when each camera's last picture was put, ns
        self.every_s = picture_every_s(0, limit, cameras)  # between two pictures of a camera; infinite: none any more
        self._left_ns = self._moved_ns = 0  # the end of what a killed recorder has left; by what all later is moved
        self._still = 0  # the newest stored picture that was put
        self.end = End()
        self.written = threading.Event()
        self._thread = threading.Thread(target=self._write, name=path.stem, daemon=True)
        self._thread.start()

    def picture(self, camera: int, at_ns: int, data: bytes) -> None:
        """Take a picture's packet, unless its camera's last one was put too lately; a new still always."""
        still = PICTURE_HEAD.unpack_from(data)[4] if len(data) > PICTURE_HEAD.size else 0
        new = still != 0 and still != self._still
        self._still = still or self._still
        if not new and at_ns - self._pictured.get(camera, -(10**18)) + EARLY_NS < min(self.every_s, 10**6) * 1e9:
            return
        if self._put(f"{CAMERA}{camera}", at_ns, data, PICTURES_WAIT):
            self._pictured[camera] = at_ns

    def state(self, at_ns: int, data: bytes) -> None:
        """Take a state's packet."""
        self._put(STATE, at_ns, data)

    def stream(self, at_ns: int, data: bytes) -> None:
        """Take a packet of a byte stream; one that the spec does not declare is left out."""
        with contextlib.suppress(ValueError, IndexError):
            self._put(f"{STREAM}{self._streams[unpack(data).stream]}", at_ns, data)

    def tell(self, topic: str, at_ns: int, data: bytes) -> None:
        """Take a command's stage or an event, encoded."""
        self._put(topic, at_ns, data)

    def close(self) -> None:
        """Write what waits, then the index; returns at once."""
        with self._news:
            self._closing = True
            self._news.notify()

    def _put(self, topic: str, at_ns: int, data: bytes, most: int = ALL_WAIT) -> bool:
        with self._news:
            if self._closing or self._queue.size + len(data) > most:
                self._queue.dropped += not self._closing
                return False
            self._queue.items.append((topic, at_ns, data))
            self._queue.size += len(data)
            self._news.notify()
        return True

    def _write(self) -> None:
        tape: Tape | None = None
        try:
            self._live.parent.mkdir(parents=True, exist_ok=True)
            tape = self._resumed()
            self._all(tape)
            tape.close()
        except OSError as error:
            log.warning("%s cannot be written: %s", self._path.name, error)
            self._cut(FAILED.format(error.strerror or "the disk failed"))
            if tape is not None:
                tape.abandon()
        except Exception:
            log.exception("%s cannot be written", self._path.name)
            self._cut(FAILED.format("a fault of the recorder"))
            if tape is not None:
                tape.abandon()
        finally:
            self._publish()
            self.end.dropped = self._queue.dropped
            self.written.set()

    def _publish(self) -> None:
        """Give the file its name: from now on it is seen."""
        with contextlib.suppress(OSError):
            if self._live.exists() and self._live.stat().st_size:
                self._live.replace(self._path)

    def _cut(self, reason: str) -> None:
        self.end.whole, self.end.reason = False, reason
        with self._news:
            self._closing = True

    def _resumed(self) -> Tape:
        """Return the tape; what a recorder that was killed has left is copied to its beginning."""
        old = self._live.with_suffix(".old")
        if not old.exists():  # beside an old one, the live one is a copy of it that was cut off
            if not self._live.exists():
                return Tape(self._live, self._about)
            self._live.replace(old)
        tape, last = Tape(self._live, self._about), 0
        for message in messages(old):
            tape.copy(message)
            last = message.at_ns
        if last:
            tape.put(EVENTS, last, {"what": "gap", "text": "The recorder was interrupted here.", "level": "warning"})
            self.end.reason = "The recorder was interrupted; a part is missing."
            self._left_ns = last
        tape.flush()
        old.unlink()
        return tape

    def _all(self, tape: Tape) -> None:
        """Write until the end."""
        flushed = 0
        while True:
            with self._news:
                if not self._queue.items and not self._closing:
                    self._news.wait(FLUSH_S)
                items = list(self._queue.items)
                self._queue.items.clear()
                self._queue.size = 0
                closing = self._closing
            for topic, put_ns, data in items:
                at_ns = self._after_left(put_ns)
                self._one(tape, topic, at_ns, data)
                if at_ns - flushed >= FLUSH_S * 1e9:
                    flushed = at_ns
                    tape.flush()
                    self._judge(tape, at_ns)
            if closing and not items:
                return
            if not self.end.whole:
                return

    def _after_left(self, at_ns: int) -> int:
        """Return the time on the tape; if the time of day was set meanwhile, it goes on at the end of what is left."""
        if self._left_ns:
            away_ns, self._left_ns = at_ns - self._left_ns, 0
            self._moved_ns = 0 if 0 <= away_ns <= AWAY_NS else -away_ns
        return at_ns + self._moved_ns

    def _one(self, tape: Tape, topic: str, at_ns: int, data: bytes) -> None:
        told: Any = data
        try:
            if topic == STATE:
                told = state_told(data, self._joints, self._channels)
            elif topic.startswith(CAMERA):
                told = picture_of(data, len(self._joints), self._coordinates)
        except ValueError as error:
            log.warning("%s: %s", self._path.name, error)
            return
        if topic in (COMMANDS, EVENTS):
            tape.copy(Message(topic, at_ns, at_ns, data))
        else:
            tape.put(topic, at_ns, told, _sent_ns(topic, told))

    def _judge(self, tape: Tape, now_ns: int) -> None:
        """Thin pictures out as the file grows, and end at its greatest size."""
        every_s = picture_every_s(tape.size, self._limit, self._cameras)
        if every_s != self.every_s:
            words = f"one in {every_s:g} s of each camera" if every_s < inf else "none any more"
            text = f"The recording has become large. Pictures from now on: {words}."
            if self._pictured:
                tape.put(EVENTS, now_ns, {"what": "thinned", "text": text, "level": "info"})
            self.every_s = every_s
        if tape.size >= self._limit:
            self._cut(TOO_LARGE)
        elif not self._room():
            self._cut(NO_ROOM)


def _sent_ns(topic: str, told: Any) -> int:
    if topic == STATE:
        return max(0, int(told["at_ms"])) * 1_000_000
    if topic.startswith(CAMERA):
        return max(0, int(told["timestamp"]["sec"])) * 1_000_000_000 + int(told["timestamp"]["nsec"])
    return max(0, unpack(told).at_ms) * 1_000_000
