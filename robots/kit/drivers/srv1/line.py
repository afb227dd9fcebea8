"""The owner's end of the rover's line: one question, one answer; a hold is sent at once, even between the two."""

import contextlib
from collections import deque
from collections.abc import Callable
from typing import TypeVar

from robots.kit.clock import TIMER, Limit, Timer
from robots.kit.contract.errors import LineGone, LineSilent, why
from robots.kit.contract.session import Permit, Trace
from robots.kit.drivers.srv1 import answers, extension, flash
from robots.kit.drivers.srv1.answers import Answer, Refusal, Status
from robots.kit.drivers.srv1.framing import ANSWER, Frames
from robots.kit.drivers.srv1.protocol import (
    CHECKSUM,
    GRAB,
    HEADER,
    HEADER_BYTES,
    LONGEST_LINE,
    NO_FAILSAFE,
    PORT,
    RESYNCHRONISE,
    VERSION,
    Malformed,
    PictureHeader,
    Size,
    checksum_of,
    confirms,
    count_of,
    version_of,
)
from robots.kit.drivers.srv1.refusals import Overtaken, StockFirmware, refusal
from robots.kit.drivers.stream import OpenStream, OwnerLine, open_stream

HELD = ANSWER + extension.Hold.letter.encode()
OPEN_S = 2.0  # the longest that opening, or sending, may take
ANSWER_S = 1.0  # how long an answer may take
QUESTIONS = 3  # how often a question is sent until it is answered
HELD_S, PICTURE_S = 0.3, 3.0  # how long the answer to a hold, and to the question for a picture, may take
BLOCK_S = 2.0  # how long the answer to a block may take
UPLOAD_S = 8.0  # a whole text, also by radio
STATUSES = 8  # the newest ones, by which the speed of the line is judged
LOOK_S = 0.05  # between two checks for a hold that has overtaken
ENDED_S, RADIO_BYTE_S = 0.3, 8 / 7000  # how long the answer to the end of a reception may take, and each byte of it
QUIET_S = 0.1  # of silence, after which everything that was under way has come
FLUSH_S = 0.002  # after an answer the rover throws away what comes at once
BEGIN, END = b"\xff\xd8", b"\xff\xd9"  # of a JPEG
MOST_NOISE = 300_000  # bytes that are thrown away while the line is put in order

T = TypeVar("T")


class RoverLine(OwnerLine):
    """Thread safe. `address` is a host, host:port, a `socket://` URL, or a file that contains one of these."""

    controller, robot, silence = "The rover", "the rover", (TimeoutError, Malformed)

    def __init__(
        self, address: str, epoch: int, trace: Trace | None = None, clock: Timer = TIMER,
        opened: OpenStream = open_stream,
    ) -> None:  # fmt: skip
        super().__init__(address, trace, clock, opened)
        self.epoch = epoch
        self._rest = bytearray()
        self._astray = False  # an answer may be missing or half read: the line is put in order before the next question
        self._held = False  # a hold was sent, and is not answered yet
        self._ends = b""  # what ends a reception into the flash buffer, while the rover may be at one
        self._free_at = 0.0
        self._took = deque[float](maxlen=STATUSES)  # how long the newest statuses took (s)
        self.size: Size | None = None  # of its pictures, as far as that is known
        self.version = ""

    @property
    def answer_s(self) -> float:
        """Return how long a status takes (s): the quickest of the newest ones; 0 before the first."""
        return min(self._took, default=0.0)

    def open(self) -> Status:
        """Connect, put the line in order, and claim the rover. Raises LineGone, LineBusy, LineSilent."""
        with self._lock:
            self._connect(OPEN_S, PORT)
            with self._watched():
                self._put_in_order()
                try:
                    self.version = self._asked_version()
                except TimeoutError:
                    self._ends = flash.END_OF_ANY  # an owner before may have been cut off while it sent rules
                    self._put_in_order()
                    self.version = self._asked_version()
        self.letters(NO_FAILSAFE, confirms(NO_FAILSAFE))  # another client's would drive it after 2 s of silence
        try:
            answer = self.ask(extension.Claim(self.epoch))
        except LineSilent as error:
            self.letters(VERSION, lambda data: True if b"Version" in data else None)  # it answers to this
            raise StockFirmware("The rover has its maker's firmware.") from error
        if not isinstance(answer, Status):
            raise LineSilent("The rover does not say how it is.")
        return answer

    def letters(self, data: bytes, answered: Callable[[bytes], T | None], permit: Permit | None = None) -> T:
        """Send published letters; `answered` gets the bytes so far and returns the answer, None while it is not whole.

        Raises LineGone, LineSilent, and whatever `permit` raises.
        """
        with self._lock, self._watched():
            self._ready()
            self._say(data, permit, data[:1].decode("latin-1"))
            limit = Limit(self._clock, ANSWER_S)
            while (found := answered(bytes(self._rest))) is None:
                self._more(limit)
            self._answered(bytes(self._rest), "answer")
            self._rest.clear()
            return found

    def _close(self) -> None:
        super()._close()
        self._astray, self._held, self._ends = False, False, b""
        self._rest.clear()

    def _fell_silent(self) -> None:
        """Have the line put in order before the next question."""
        self._astray = True
        self._rest.clear()

    def hold(self) -> None:
        """Send a hold at once, also within an exchange. The status tells whether it arrived.

        Raises:
            LineGone: it could not be sent.

        """
        with self._writing:
            stream, self._held = self._open_line(), True
            try:
                stream.sendall(extension.HOLD)
            except (OSError, ValueError) as error:
                raise LineGone(f"The connection to the rover broke: {why(error)}.") from error
        self._noted(">", extension.HOLD, "hold")

    def ask(self, command: extension.Command, seconds: float = ANSWER_S, permit: Permit | None = None) -> Answer:
        """Send a command behind `%` and return its answer. `permit` is called last. Nothing is sent twice.

        Raises:
            LineGone, LineSilent: the wire. LineBusy: another owner commands the rover.
            ControllerRefused: the rover refuses it. And whatever `permit` raises.

        """
        with self._lock, self._watched():
            while True:
                self._ready()
                limit = Limit(self._clock, seconds)
                self._say(extension.encode(command), permit, type(command).__name__.lower())
                try:
                    answer = self._answer_to(command.letter, limit)
                    if isinstance(answer, Status):
                        self._took.append(seconds - limit.remaining)
                    break
                except Overtaken:
                    if not isinstance(command, extension.Ask):  # a question may be asked again, and nothing else
                        raise
        if isinstance(answer, Refusal):
            raise refusal(answer.reason)
        return answer

    def status(self) -> Status:
        """Ask for the status; a question that is not answered is asked again. Raises as `ask`."""
        for left in reversed(range(QUESTIONS)):
            try:
                answer = self.ask(extension.Ask(), ANSWER_S / QUESTIONS if left else ANSWER_S)
            except LineSilent:
                if not left:
                    raise
            else:
                break
        assert isinstance(answer, Status)
        return answer

    def picture(self, seconds: float = PICTURE_S) -> bytes | None:
        """Ask for a picture until one comes, at most so many seconds; None where the camera is busy.

        Raises LineGone, LineSilent.
        """
        limit = Limit(self._clock, seconds)
        with self._lock, self._watched():
            self._ready()
            self._say(GRAB, None, "picture")
            try:
                return self._taken(limit)
            except TimeoutError:
                self._astray = True
            except Overtaken:
                pass
        return None

    def upload(self, data: bytes, permit: Permit) -> None:
        """Put bytes into the rover's flash buffer and compare their checksum. `permit` is called before each of them.

        The line is in use until the end; a hold ends it. Raises LineGone; LineSilent where it was not done, and may be
        begun again; and whatever `permit` raises.
        """
        with self._lock, self._watched():
            self._ready()
            limit = Limit(self._clock, UPLOAD_S)
            self._ends = flash.END
            try:
                flash.send(data, lambda piece: self._exchanged(piece, limit, permit))
                received = count_of(self._line(limit))
            except BaseException:
                self._astray = True
                raise
            self._answered(b"", f"{received} bytes in the flash buffer")
            self._ready()
            self._say(CHECKSUM, permit, "checksum")
            if checksum_of(self._line(Limit(self._clock, ANSWER_S))) != flash.buffer_crc(data):
                raise Malformed("the rover has something else in its flash buffer")
            self._answered(b"", "checksum")

    def _exchanged(self, piece: bytes, limit: Limit, permit: Permit) -> bytes:
        """Send a piece of an upload unless a hold has overtaken it; return the next byte.

        Raises TimeoutError, Overtaken, OSError.
        """
        if limit.over:
            raise TimeoutError
        with self._writing:
            if self._held:
                raise Overtaken
            permit()
            self._open_line().sendall(piece)
        if piece:
            self._noted(">", piece, f"{len(piece)} bytes of an upload")
        self._until(lambda: len(self._rest), Limit(self._clock, min(BLOCK_S, limit.remaining)))
        said = bytes(self._rest[:1])
        del self._rest[:1]
        return said

    def _line(self, limit: Limit) -> bytes:
        """Return the next line. Raises TimeoutError, Overtaken, OSError."""
        self._until(lambda: b"\n" in self._rest or len(self._rest) > LONGEST_LINE, limit)
        line, _, rest = bytes(self._rest).partition(b"\n")
        self._rest[:] = rest
        return line

    def _until(self, come: Callable[[], object], limit: Limit) -> None:
        """Wait for more bytes until `come` is true. Raises TimeoutError, Overtaken, OSError."""
        while self._held or not come():
            if self._held:
                raise Overtaken
            with contextlib.suppress(TimeoutError):
                self._more(Limit(self._clock, min(LOOK_S, limit.remaining)))
                continue
            if limit.remaining <= 0:
                raise TimeoutError

    def _taken(self, limit: Limit) -> bytes:
        """Wait for a picture's header and its JPEG, and return the JPEG. Raises TimeoutError, OSError."""
        while (at := self._rest.find(HEADER)) < 0 or len(self._rest) < at + HEADER_BYTES:
            self._more_of_picture(limit)
        header = PictureHeader.decode(bytes(self._rest[at : at + HEADER_BYTES]))
        self.size = header.size
        del self._rest[: at + HEADER_BYTES]
        while len(self._rest) < header.length:
            self._more_of_picture(limit)
        data = bytes(self._rest[: header.length])
        del self._rest[: header.length]
        if not (data.startswith(BEGIN) and data.endswith(END)):  # a byte was lost, or the length is wrong
            raise TimeoutError
        self._answered(b"", f"picture of {header.length} bytes")
        return data

    def _more_of_picture(self, limit: Limit) -> None:
        """Wait for more bytes. Raises TimeoutError, Overtaken, OSError."""
        self._more(limit)
        if self._held and (at := self._rest.find(HELD)) >= 0 and self._rest.find(b"\n", at) >= 0:
            self._heard_hold()
            raise Overtaken

    def _answer_to(self, letter: str, limit: Limit) -> Answer:
        """Return the answer to that letter; other answers are dropped. Raises TimeoutError, Overtaken, OSError."""
        frames = Frames(ANSWER)
        while True:
            for frame in frames.feed(bytes(self._rest)):
                if frame.letter == letter:
                    answer = answers.decode(frame)
                    self._answered(frame.encode(ANSWER), type(answer).__name__.lower())
                    self._rest.clear()
                    return answer
                if frame.letter == extension.Hold.letter:
                    self._heard_hold()
                    raise Overtaken
            self._rest.clear()
            self._more(limit)

    def _heard_hold(self) -> None:
        self._held = False
        self._rest.clear()
        self._answered(b"", "held")

    def _answered(self, data: bytes, words: str) -> None:
        self._ends = b""
        self._free_at = self._clock.monotonic() + FLUSH_S
        self._noted("<", data, words)

    def _ready(self) -> None:
        """Wait until the rover reads again; put the line in order where an answer is missing."""
        self._open_line()
        if self._astray:
            self._put_in_order()
        if self._held:
            with contextlib.suppress(TimeoutError):  # a hold may be lost; the next status tells
                self._answer_to(extension.Hold.letter, Limit(self._clock, HELD_S))
            self._held = False
        left = self._free_at - self._clock.monotonic()
        if left > 0:
            self._clock.sleep(left)

    def _put_in_order(self) -> None:
        """End a command that may have been cut off, and throw away everything that still comes.

        Raises TimeoutError where that does not end.
        """
        with self._writing:
            self._open_line().sendall(self._ends or RESYNCHRONISE)
        if self._ends:
            with contextlib.suppress(TimeoutError):  # it answers to one of these bytes, whatever state it is in
                self._more(Limit(self._clock, ENDED_S + RADIO_BYTE_S * len(self._ends)))
        limit, thrown = Limit(self._clock, ANSWER_S), 0
        with contextlib.suppress(TimeoutError):
            while thrown < MOST_NOISE and not limit.over:
                thrown += self._more(Limit(self._clock, QUIET_S))
            raise ConnectionResetError("what the rover says has no end")
        self._rest.clear()
        self._astray = self._held = False
        self.size = None  # the command that was cut off may have changed it

    def _asked_version(self) -> str:
        """Return what the firmware calls itself. Raises TimeoutError, OSError."""
        self._say(VERSION, None, "version")
        limit = Limit(self._clock, ANSWER_S)
        while (end := self._rest.find(b"\n", self._rest.find(b"Version"))) < 0 or b"Version" not in self._rest:
            self._more(limit)
        line = bytes(self._rest[max(0, self._rest.find(b"##")) : end])
        self._rest.clear()
        self._answered(line, line.decode("latin-1"))
        return version_of(line)

    def _more(self, limit: Limit) -> int:
        """Wait for more bytes; return how many came. Raises TimeoutError, OSError."""
        left = limit.remaining
        if left <= 0:
            raise TimeoutError
        data = self._open_line().receive(65_536, left)
        if not data:
            raise ConnectionError("the rover's Wi-Fi module has closed the connection")
        self._rest += data
        if len(self._rest) > MOST_NOISE:
            raise ConnectionResetError("what the rover says has no end")
        return len(data)

    def _say(self, data: bytes, permit: Permit | None, words: str) -> None:
        self._send(data, permit)
        self._noted(">", data, words)

    def _noted(self, way: str, data: bytes, words: str) -> None:
        if self._trace is not None:
            self._trace(way, data, words)
