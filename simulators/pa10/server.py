"""The network side of the museum arm: one client at a time, lines in, lines out.

After Dziemian et al. 2004, figure 4: network threads apart from the control loop. Ours: the client may need a token,
an owner with a newer epoch replaces an older one, `W` is answered when the arm rests while other lines go on, `h`
overtakes everything, the end of the connection holds the arm, and the journal has the cause of each end.
"""

import contextlib
from collections.abc import Callable, Iterator
from functools import partial
from typing import Protocol

from robots.kit.clock import TIMER, Timer
from robots.kit.drivers.pa10.protocol import LONGEST, LONGEST_PROGRAM, LONGEST_TEXT, Malformed, Request, parse
from simulators.common.faults import FaultBoard
from simulators.common.journal import Note
from simulators.common.tcp import Line, Server
from simulators.pa10.client import Client, Order

WAIT_S = 120.0
MOST_STRANGERS = 16  # undecided connections; the oldest is closed for a new one


class Arm(Protocol):
    """The application behind the network."""

    def order(self, request: Request) -> Order:
        """Return the function that answers a request, for the present state."""

    def hold(self) -> None:
        """Bring the arm to rest."""

    def wait(self, seconds: float) -> str:
        """Wait for rest; return the answer to `W`."""

    def keep(self, number: int, text: str) -> None:
        """Replace a stored program. Raises Malformed, Refused."""


class Upload:
    """A program that is being received; it is stored only after its dot."""

    def __init__(self, number: int) -> None:
        self._number, self._lines, self._size, self._wrong = number, list[str](), 0, ""

    def add(self, line: str) -> None:
        """Add a line; the rest of a program that is too long is dropped."""
        self._size += len(line) + 1
        if not (line.isascii() and line.replace("\t", " ").isprintable()):
            self._wrong = self._wrong or f"line {len(self._lines) + 1}: the line must be plain ASCII text"
        elif self._size > LONGEST_TEXT or len(self._lines) >= LONGEST_PROGRAM:
            self._wrong = self._wrong or f"a program has at most {LONGEST_PROGRAM} lines and {LONGEST_TEXT} characters"
        if not self._wrong:
            self._lines.append(line)

    def end(self, arm: Arm) -> str:
        """Replace the stored program; return the answer. Raises Malformed, Refused."""
        if self._wrong:
            raise Malformed(self._wrong)
        arm.keep(self._number, "\n".join(self._lines))
        return f"ok program {self._number} {len(self._lines)} lines"


class Network(Server):
    """Serves one client of those that connect."""

    def __init__(
        self, arm: Arm, faults: FaultBoard, note: Note, token: str = "",
        allowed: tuple[str, ...] = ("127.0.0.1", "::1"), clock: Timer = TIMER,
    ) -> None:  # fmt: skip
        super().__init__(clock)
        self._arm, self._faults, self._note, self._token, self._allowed = arm, faults, note, token, allowed
        self._present: Client | None = None
        self._strangers: list[Client] = []
        self._newest = 0  # the newest epoch so far
        self._left = self._clock.monotonic()  # since when nobody has been connected
        self._door = clock.lock()  # for connecting and disconnecting

    def close(self) -> None:
        """Accept no more connections; end the present one."""
        super().close()
        with self._door:
            self._end("the application ends")

    def restart(self, why: str, again: Callable[[str], None], forget: bool = False) -> None:
        """Disconnect the client and restart the application; nobody can connect meanwhile.

        `forget`: the owner has been away for so long that its epoch excludes nobody any more.
        """
        with self._door:
            self._end(f"watchdog: {why}")
            again(why)
            self._left = self._clock.monotonic()
            self._newest = 0 if forget else self._newest

    def watch(self, silence_s: float, nobody_s: float, again: Callable[[str], None]) -> None:
        """Restart the application if the owner is silent, or if nobody connects."""
        with self._door:
            client = self._present
            if client is not None and client.silent_s > silence_s:
                self.restart(f"no line for {silence_s:g} s", again)
            elif client is None and self._clock.monotonic() - self._left > nobody_s:
                self.restart(f"nobody connected for {nobody_s:g} s", again, forget=True)

    def _end(self, cause: str) -> None:
        """End the present connection; the arm holds. The caller has the lock."""
        client, self._present = self._present, None
        if client is None:
            return
        self._left = self._clock.monotonic()
        self._arm.hold()
        self._note("disconnected", peer=client.peer, cause=cause)
        client.shut()

    def _accept(self, line: Line, host: str, name: str) -> None:
        client = Client(line, name, self._faults, self._note, self._clock)
        with self._door:
            self._strangers.append(client)
            oldest = self._strangers.pop(0) if len(self._strangers) > MOST_STRANGERS else None
        if oldest is not None:
            oldest.shut()
        try:
            self._clock.spawn(partial(self._serve, client, host), "reader")
        except RuntimeError:  # the system has no thread left for now
            self._left_by(client, "no thread is left for it")

    def _serve(self, client: Client, host: str) -> None:
        cause = "it was ended from here"
        try:
            if host not in self._allowed:
                self._turn_away(client, "this address is not allowed")
            else:
                self._read(client)
        except EOFError as error:
            cause = str(error)
        except OSError as error:
            cause = f"the line broke: {error.strerror or error}"
        except Exception as error:  # noqa: BLE001 - one client must not end the others' service
            cause = f"its reader failed: {type(error).__name__}: {error}"
            self._note("crash", error=cause)
        self._left_by(client, cause)

    def _left_by(self, client: Client, cause: str) -> None:
        """Forget a client that has gone; if it was the present one, the arm holds."""
        with self._door:
            if self._present is client:
                self._end(cause)
            with contextlib.suppress(ValueError):
                self._strangers.remove(client)
        client.close()

    def _read(self, client: Client) -> None:
        """Read until the end; answer lines, or queue them."""
        upload: Upload | None = None
        for text in lines(client.line):
            client.heard_at = self._clock.monotonic()
            if self._faults.value("awol"):
                continue
            if text.split() == ["h"] and self._present is client:
                self._arm.hold()
                client.say("ok hold")
            elif upload is not None:
                if text.strip() == ".":
                    client.put(partial(upload.end, self._arm))
                    upload = None
                else:
                    upload.add(text)
            else:
                try:
                    request = parse(text)
                except Malformed as error:
                    self._refuse(client, error)
                    continue
                if self._present is not client and not self._come_in(client, request):
                    return
                if request.letter == "u":
                    upload = Upload(int(request.numbers[0]))
                else:
                    client.put(self._order(client, request))

    def _refuse(self, client: Client, error: Malformed) -> None:
        def refuse(error: Malformed = error) -> str:
            raise error

        if self._present is client:
            client.put(refuse)  # in its place
        else:
            client.say(client.answer_of(refuse))

    def _order(self, client: Client, request: Request) -> Order:
        if request.letter == "i":
            return partial(self._claim_again, client, request)
        if request.letter == "W":
            return partial(client.wait, partial(self._arm.wait, WAIT_S))
        return self._arm.order(request)

    def _come_in(self, client: Client, request: Request) -> bool:
        """Accept one client: the first, or an owner that replaces the present one."""
        why = self._why_not(client, request)
        if why:
            self._turn_away(client, why)
            return False
        client.begin()
        return True

    def _why_not(self, client: Client, request: Request) -> str:
        claims = request.letter == "i"
        if self._token and not (claims and request.word == self._token):
            return "say i, your epoch and the token first"
        with self._door:
            other, epoch = self._present, int(request.numbers[0]) if claims else self._newest
            if epoch < self._newest:
                return f"epoch {epoch} is over; {self._newest} has driven since"
            if other is not None and not (claims and (epoch > other.epoch or not other.owner)):
                return "another client is connected"
            self._end(f"epoch {epoch} took over")
            with contextlib.suppress(ValueError):
                self._strangers.remove(client)
            client.epoch, client.owner = epoch, claims
            self._present, self._newest = client, epoch
            self._note("connected", peer=client.peer, epoch=epoch)
        return ""

    def _claim_again(self, client: Client, request: Request) -> str:
        """Answer `i` of a client that is accepted already."""
        epoch = int(request.numbers[0])
        with self._door:
            if self._token and request.word != self._token:
                raise Malformed("i: this is not the token")
            if epoch < self._newest:
                raise Malformed(f"epoch {epoch} is over; {self._newest} has driven since")
            if self._present is client:
                client.epoch = self._newest = epoch
                client.owner = True
        return f"ok epoch {epoch}"

    def _turn_away(self, client: Client, why: str) -> None:
        self._note("refused", peer=client.peer, why=why)
        client.say(f"e busy {why}")


PIECE = 4096


def lines(line: Line) -> Iterator[str]:
    """Yield each line without its end, until the connection ends.

    A line that is too long is cut so that the reader can see this; bytes that are not ASCII become U+FFFD. An
    unfinished line at the end is dropped.

    Raises:
        OSError: the connection was lost.
        EOFError: it was closed; the message says how.
    """
    rest, cut = b"", False
    while data := line.receive(PIECE):
        *whole, last = data.split(b"\n")
        for part in whole:
            yield (rest + part)[: LONGEST + 2].decode("ascii", "replace").rstrip("\r")
            rest, cut = b"", False
        rest = (rest + last)[: LONGEST + 2]
        cut = bool(rest)
    raise EOFError("half a line, then the end" if cut else "the client closed the line")
