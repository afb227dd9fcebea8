"""The owner's end of the museum arm's TCP line: one question, one answer."""

from robots.kit.addresses import HIDDEN
from robots.kit.clock import TIMER, Limit, Timer
from robots.kit.contract.errors import ControllerRefused, LineBusy, LineGone, OutOfWorkspace
from robots.kit.contract.session import Permit, Trace
from robots.kit.drivers.pa10.protocol import LONGEST_ANSWER, ArmState, Malformed, Request, lines
from robots.kit.drivers.stream import OpenStream, OwnerLine, open_stream

ANSWER_S = 1.0  # by the machine's clock, as all limits here: how long it may take to plan and to answer
CHECKED_S = 60.0  # a whole program
HOLD, HELD = b"h\n", "ok hold"


class ArmLine(OwnerLine):
    """Thread safe; `address` is host:port, a `socket://` URL, or a file that contains the address."""

    controller, robot = "The arm's controller", "the arm"

    def __init__(
        self, address: str, epoch: int, token: str, trace: Trace | None, clock: Timer = TIMER,
        opened: OpenStream = open_stream,
    ) -> None:  # fmt: skip
        super().__init__(address, trace, clock, opened)
        self._epoch, self._token = epoch, token
        self._holds = 0  # written, not yet answered
        self._rest = b""
        self.resent = self.broken = 0

    def open(self) -> None:
        """Connect and identify the owner. Raises LineGone, LineBusy."""
        with self._lock:
            self._connect(ANSWER_S)
        claim = Request("i", (float(self._epoch),), self._token)
        shown = Request(claim.letter, claim.numbers, HIDDEN if self._token else "")  # staff watch the wire
        try:
            self._exchange(claim.encode(), ANSWER_S, shown=shown.encode())
        except ControllerRefused as error:
            self.close()
            raise LineBusy(f"The arm is used by another client: {error}") from error

    def _close(self) -> None:
        super()._close()
        self._rest, self._holds = b"", 0

    def hold(self) -> None:
        """Send `h` at once, also while an answer is awaited; return when it was answered. Raises as `ask`."""
        with self._writing:
            line = self._open_line()
            self._holds += 1
            with self._watched():
                line.sendall(HOLD)
        with self._lock:
            if self._stream is not line:
                raise LineGone("The connection to the arm was lost before the hold was answered.")
            answer = HELD  # a thread that waited for another answer may have read it
            if self._holds:
                with self._watched():
                    answer = self._next_line(Limit(self._clock, ANSWER_S))
                self._hold_answered()
            if answer != HELD:
                self._close()  # an answer that comes later must not be taken for the next one
        self._noted(HOLD, answer)
        if self._judged(answer) != HELD:
            raise ControllerRefused(f"The controller gave an unexpected answer to a hold: {answer[:60]}")

    def ask(self, request: Request, seconds: float = ANSWER_S, permit: Permit | None = None) -> str:
        """Send one line and return its answer; if none comes, the connection ends.

        Raises:
            LineGone, LineSilent: the wire. OutOfWorkspace, ControllerRefused: the controller.
            And whatever `permit` raises.
        """
        return self._exchange(request.encode(), seconds, permit)

    def teach(self, number: int, program: str, seconds: float = ANSWER_S) -> str:
        """Send a program under a number. Raises as `ask`."""
        data = "\n".join([f"u {number}", *(line for _, line in lines(program)), ".", ""]).encode("ascii", "replace")
        return self._exchange(data, seconds)

    def _exchange(self, data: bytes, seconds: float, permit: Permit | None = None, shown: bytes = b"") -> str:
        with self._lock:
            self._open_line()
            with self._watched():
                self._send(data, permit)
                answer = self._answer(Limit(self._clock, seconds))
        self._noted(shown or data, answer)
        return self._judged(answer)

    def _noted(self, data: bytes, answer: str) -> None:
        if self._trace is not None:
            self._trace(">", data, data.decode().strip())
            self._trace("<", answer.encode(), answer)

    def _answer(self, limit: Limit) -> str:
        """Return the next line that is not the answer to a hold sent meanwhile."""
        while True:
            text = self._next_line(limit)
            if text != HELD or not self._holds:
                return text
            self._hold_answered()

    def _hold_answered(self) -> None:
        with self._writing:
            self._holds = max(0, self._holds - 1)

    def _next_line(self, limit: Limit) -> str:
        """Return the next line, which must be whole before `limit`. Raises OSError, ValueError."""
        line = self._open_line()
        while b"\n" not in self._rest:
            if len(self._rest) > LONGEST_ANSWER:
                raise ConnectionResetError("the controller's answer has no end")
            left = limit.remaining  # asked once: a negative one would wait for ever
            if left <= 0:
                raise TimeoutError
            data = line.receive(4096, left)
            if not data:
                raise ConnectionResetError("the controller closed the line")
            self._rest += data
        text, _, self._rest = self._rest.partition(b"\n")
        return text.decode("ascii", "replace").strip()

    @staticmethod
    def _judged(answer: str) -> str:
        if not answer.startswith("e "):
            return answer
        _, code, *words = answer.split(" ")
        text = " ".join(words)
        text = f"{text[:1].upper()}{text[1:]}."
        if code in ("range", "box"):
            raise OutOfWorkspace(text)
        raise ControllerRefused(text)

    def state(self) -> ArmState:
        """Ask for the whole state. Raises as `ask`; ControllerRefused for an answer that is not a state."""
        answer = self.ask(Request("s"))
        try:
            return ArmState.decode(answer)
        except Malformed as error:
            self.broken += 1
            raise ControllerRefused(f"The controller's answer is not a state: {answer[:60]}") from error
