"""A client of any robot behind rosbridge v2, for drivers whose owner uses threads.

Topics arrive in the thread of the connection; calls of services wait for their answers by id, so a hold need not wait
for another call. An answer that comes too late is dropped. So is a message that is too long, such as a large picture,
and one that cannot be read: the connection, by which the robot is driven, goes on.
"""

import contextlib
import itertools
import logging
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from robots.kit.clock import TIMER, Timer
from robots.kit.contract.errors import ControllerRefused, LineGone, LineSilent, why
from robots.kit.contract.session import Permit
from robots.kit.drivers.rosbridge import Malformed, Message, decode, encode, identifier, nested
from robots.kit.drivers.stream import written_address
from robots.kit.opening import why_not

log = logging.getLogger(__name__)
ANSWER_S = 1.0
OPEN_S = 5.0  # real time, as the next two: the network's
SEND_S = 1.0  # for a whole frame, to a robot that reads slowly or not at all
PING_S = 5.0
MOST_BYTES = 1_000_000  # of a message from the robot; a longer one is left out
MOST_READ = 64_000_000  # a longer one ends the connection
Heard = Callable[[Message], None]


class Connection(Protocol):
    """An open connection to a rosbridge, as threads use it; `websockets` has the usual one."""

    def send(self, frame: str, /) -> None:
        """Send a frame. Raises an error once the connection has ended."""

    def __iter__(self) -> Iterator[str | bytes]:
        """Yield what arrives, until the connection has ended."""

    def close(self) -> None:
        """End it; a thread that waits for a frame is woken with an error."""


OpenConnection = Callable[[str], Connection]


def connected(address: str) -> Connection:
    """Return a connection to a ws:// URL. Raises whatever its library raises."""
    line = connect(
        address, compression=None, max_size=MOST_READ, open_timeout=OPEN_S, close_timeout=1.0,
        ping_interval=PING_S, ping_timeout=2 * PING_S, proxy=None,
    ).__enter__()  # fmt: skip
    line.socket.settimeout(SEND_S)  # reading waits by itself
    return line


@dataclass
class _Call:
    answered: threading.Event = field(default_factory=threading.Event)
    values: Any = None
    result: bool = False


class Bridge:
    """Thread safe. `address` is a ws:// URL, host:port, or a file that contains one of them."""

    def __init__(self, address: str, clock: Timer = TIMER, opened: OpenConnection = connected) -> None:
        self._address, self._clock, self._opened = address, clock, opened
        self._line: Connection | None = None
        self._reader: threading.Thread | None = None
        self._opening = clock.lock()
        self._heard: dict[str, tuple[str, Heard, float]] = {}
        self._calls: dict[str, _Call] = {}
        self._numbers = itertools.count(1)
        self.complaint = ""  # the robot's last message about a frame of ours
        self.unreadable = 0  # messages of the robot that were dropped
        self.left_out = 0  # because they were too long
        self.heard_at = 0.0  # on its clock (s), of the newest frame

    @property
    def is_open(self) -> bool:
        """Return whether a connection is open."""
        return self._line is not None

    def open(self) -> None:
        """Connect, and subscribe to what was subscribed to before. Raises LineGone."""
        with self._opening:
            self._close()
            try:
                line = self._opened(self._where())
            except Exception as error:  # the library asserts where it does not expect an answer
                raise LineGone(f"The robot's rosbridge cannot be reached: {why_not(error)}") from error
            self._line, self.heard_at = line, self._clock.monotonic()
            # raises where the system has no thread left; the line is closed before the next attempt
            self._reader = self._clock.spawn(partial(self._read, line), "rosbridge")
        for topic, (kind, _, every_s) in list(self._heard.items()):
            self._subscribe(topic, kind, every_s)

    def _where(self) -> str:
        text = written_address(self._address)
        return text if text.startswith(("ws://", "wss://")) else f"ws://{text.removeprefix('tcp:')}"

    def close(self) -> None:
        """Close the connection."""
        with self._opening:
            self._close()

    def _close(self) -> None:
        line, self._line = self._line, None
        if line is not None:
            with contextlib.suppress(Exception):
                line.close()
        if self._reader is not None and self._reader is not threading.current_thread():
            self._reader.join(2.0)

    def subscribe(self, topic: str, kind: str, on_message: Heard, every_s: float = 0.0) -> None:
        """Have `on_message` called with each message of a topic, at most one every `every_s`; also after a new `open`.

        It is called in the connection's thread and must not wait. Raises LineGone.
        """
        self._heard[topic] = kind, on_message, every_s
        if self.is_open:
            self._subscribe(topic, kind, every_s)

    def _subscribe(self, topic: str, kind: str, every_s: float) -> None:
        self._send(encode(op="subscribe", topic=topic, type=kind, throttle_rate=int(every_s * 1000), queue_length=1))

    def unsubscribe(self, topic: str) -> None:
        """End a subscription. Raises LineGone."""
        if self._heard.pop(topic, None) and self.is_open:
            self._send(encode(op="unsubscribe", topic=topic))

    def publish(self, topic: str, message: Message, permit: Permit | None = None) -> None:
        """Publish a message; `permit` is called last. Raises LineGone, and what `permit` raises."""
        frame = encode(op="publish", topic=topic, msg=message)
        if permit is not None:
            permit()
        self._send(frame)

    def call(self, service: str, args: Message | None = None, seconds: float = ANSWER_S) -> Message:
        """Call a service; return its values.

        Raises:
            LineGone, LineSilent: the connection.
            ControllerRefused: the robot does not know the service or cannot read the arguments.

        """
        number = f"call:{next(self._numbers)}"
        waiting = self._calls[number] = _Call()
        try:
            self._send(encode(op="call_service", id=number, service=service, args=args or {}))
            if not self._clock.wait(waiting.answered, seconds):
                raise LineSilent(f"The robot does not answer to {service}.")
        finally:
            self._calls.pop(number, None)
        if self._line is None and waiting.values is None:
            raise LineGone("The connection to the robot was lost before it answered.")
        if not waiting.result or not isinstance(waiting.values, dict):
            raise ControllerRefused(f"The robot refused {service}: {str(waiting.values)[:200]}.")
        return waiting.values

    def _send(self, frame: str) -> None:
        line = self._line
        if line is None:
            raise LineGone("The robot's rosbridge is not connected.")
        try:
            line.send(frame)
        except Exception as error:
            self._lost(line)
            raise LineGone(f"The connection to the robot broke: {why(error)}.") from error

    def _read(self, line: Connection) -> None:
        """Hand on the messages that arrive, until the connection ends."""
        try:
            for data in line:
                self.heard_at = self._clock.monotonic()
                if len(data) > MOST_BYTES:
                    self._leave_out(len(data))
                    continue
                try:
                    self._take(decode(data))
                except (Malformed, TypeError, ValueError):
                    self.unreadable += 1
                except Exception:  # of whoever hears it; the next message is another matter
                    self.unreadable += 1
                    log.exception("a message of the robot could not be used")
        except (OSError, ConnectionClosed):
            pass
        except Exception:
            log.exception("the connection to the robot ended")
        finally:
            self._lost(line)

    def _leave_out(self, size: int) -> None:
        self.left_out += 1
        if self.left_out == 1:
            log.warning("messages of over %d bytes are left out: the robot sent one of %d", MOST_BYTES, size)

    def _take(self, found: Message) -> None:
        op = found.get("op")
        if op == "publish":
            known = self._heard.get(str(found.get("topic")))
            if known is not None:
                known[1](nested(found, "msg"))
        elif op == "service_response":
            call = self._calls.get(str(identifier(found)))
            if call is not None:
                call.values, call.result = found.get("values"), found.get("result") is True
                call.answered.set()
        elif op == "status":
            self.complaint = str(found.get("msg", ""))[:300]

    def _lost(self, line: Connection) -> None:
        """Forget a connection that has ended; threads that wait for an answer get an error at once."""
        if self._line is line:
            self._line = None
            for call in list(self._calls.values()):
                call.answered.set()
