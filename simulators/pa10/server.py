"""The network side of the museum arm: one client, lines in, lines out, and the watchdog.

After Dziemian et al. 2004, figure 4: a thread for the network apart from the control loop, a
second one that starts the control application again on silence, or when nobody connects. Ours:
the client may be asked for a token, an owner with a newer epoch takes the place of an older
one, `W` is answered when its time has come while other lines go on, `h` overtakes a target that
is still being planned, and each drop is noted with its cause.
"""

import contextlib
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from robots.drivers.pa10.protocol import LONGEST, LONGEST_PROGRAM, MOTIONS, Malformed, Request, parse, program
from robots.motion.planner import Refused
from simulators.common.faults import FaultBoard

Act = Callable[[Request], str]
Plan = Callable[[Request], Callable[[], str]]
Note = Callable[..., None]
WAIT_S = 120.0
PLANNED = (*MOTIONS, "p")


@dataclass
class Client:
    """Who is connected."""

    line: socket.socket
    peer: str
    epoch: int = 0
    known: bool = False
    writing: threading.Lock = field(default_factory=threading.Lock)
    planning: threading.Thread | None = None

    def __post_init__(self) -> None:
        """Open the reader."""
        self.lines = self.line.makefile("rb")

    def in_order(self) -> None:
        """Wait until what was asked before is planned and answered."""
        if self.planning is not None:
            self.planning.join()


class Network:
    """Listens on `port` (0: any); `act` answers a request, `plan` returns what does, `wait` one that waits for rest."""

    def __init__(
        self, port: int, act: Act, plan: Plan, wait: Callable[[float], str], faults: FaultBoard, note: Note,
        keep: Callable[[int, str], None], token: str = "", allowed: tuple[str, ...] = ("127.0.0.1", "::1"),
    ) -> None:  # fmt: skip
        self._act, self._plan, self._wait, self._faults, self._note = act, plan, wait, faults, note
        self._token, self._allowed = token, allowed
        self._keep = keep
        self._server = socket.create_server(("127.0.0.1", port))
        self._client: Client | None = None
        self._newest = 0  # the newest epoch that was heard
        self._choosing = threading.Lock()
        self.heard = time.monotonic()
        threading.Thread(target=self._listen, name="network", daemon=True).start()

    @property
    def port(self) -> int:
        """Return the port that is listened to."""
        return int(self._server.getsockname()[1])

    @property
    def connected(self) -> bool:
        """Tell whether somebody is connected."""
        return self._client is not None

    @property
    def silent_s(self) -> float:
        """Return how long nothing was heard (s); whoever waits for a plan is not silent."""
        client = self._client
        if client is not None and client.planning is not None and client.planning.is_alive():
            self.heard = time.monotonic()
        return time.monotonic() - self.heard

    def drop(self, cause: str) -> None:
        """Close the connection."""
        with self._choosing:
            client, self._client = self._client, None
        if client is not None:
            self._note("disconnected", peer=client.peer, cause=cause)
            with contextlib.suppress(OSError):
                client.line.shutdown(socket.SHUT_RDWR)
            client.line.close()
        self.heard = time.monotonic()

    def close(self) -> None:
        """Stop listening."""
        self._server.close()
        self.drop("the application ends")

    def _listen(self) -> None:
        while True:
            try:
                line, address = self._server.accept()
            except OSError:
                return
            line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            client = Client(line, f"{address[0]}:{address[1]}")
            threading.Thread(target=self._serve, args=(client, address[0]), name="client", daemon=True).start()

    def _serve(self, client: Client, host: str) -> None:
        if host not in self._allowed:
            self._turn_away(client, "this address is not allowed")
            return
        cause = "the client closed the line"
        try:
            while True:
                raw = client.lines.readline(LONGEST + 2)
                if not raw:
                    break
                if not raw.endswith(b"\n"):
                    cause = "half a line, then the end" if len(raw) <= LONGEST else "a line that is too long"
                    break
                if not self._one(client, raw):
                    return
        except OSError as error:
            cause = f"the line broke: {error.strerror or error}"
        if self._client is client:
            self.drop(cause)
        else:
            client.line.close()

    def _one(self, client: Client, raw: bytes) -> bool:
        """Answer one line; False when the client is not to be served."""
        try:
            text = raw.decode("ascii").rstrip("\r\n")
        except UnicodeDecodeError:
            text = "?"
        try:
            request = parse(text)
            if self._client is not client and not self._choose(client, request):
                return False
            self.heard = time.monotonic()
            if self._faults.value("awol"):
                return True
            if request.letter != "h":
                client.in_order()  # one after the other; only a hold overtakes
            if request.letter in PLANNED:
                # in a thread, so that this one hears a hold meanwhile
                client.planning = threading.Thread(
                    target=self._told, args=(client, self._plan(request)), name="plan", daemon=True
                )
                client.planning.start()
                return True
            if request.letter == "W":
                threading.Thread(target=self._later, args=(client,), name="wait", daemon=True).start()
                return True
        except Malformed as error:
            self._say(client, f"e form {error}")
            return True
        self._told(client, lambda: self._answer(client, request))
        return True

    def _told(self, client: Client, answer: Callable[[], str]) -> None:
        """Say the answer, or why it is refused."""
        try:
            said = answer()
        except Malformed as error:
            said = f"e form {error}"
        except Refused as error:
            said = f"e {error.code} {error}"
        self._say(client, said)

    def _answer(self, client: Client, request: Request) -> str:
        if request.letter == "i":
            return f"ok epoch {client.epoch}"
        if request.letter == "u":
            return self._take_over(client, int(request.numbers[0]))
        return self._act(request)

    def _choose(self, client: Client, request: Request) -> bool:
        """Let one client in: the first, or an owner whose epoch is newer than the present one's."""
        if request.letter == "i":
            client.epoch, client.known = int(request.numbers[0]), request.word == self._token
        elif not self._token:
            client.known, client.epoch = True, self._newest  # somebody who types, where nobody is
        if not client.known:
            self._turn_away(client, "say i, your epoch and the token first")
            return False
        with self._choosing:
            other, stale = self._client, client.epoch < self._newest
            newer = other is None or (request.letter == "i" and client.epoch > other.epoch)
            if newer and not stale:
                self._client, self._newest = client, max(self._newest, client.epoch)
        if stale:
            self._turn_away(client, f"epoch {client.epoch} is over; {self._newest} has driven since")
            return False
        if not newer:
            self._turn_away(client, "another client is connected")
            return False
        if other is not None:
            self._note("disconnected", peer=other.peer, cause=f"epoch {client.epoch} took over")
            with contextlib.suppress(OSError):
                other.line.shutdown(socket.SHUT_RDWR)
            other.line.close()
        self._note("connected", peer=client.peer, epoch=client.epoch)
        return True

    def _turn_away(self, client: Client, why: str) -> None:
        self._note("refused", peer=client.peer, why=why)
        self._say(client, f"e busy {why}")
        client.line.close()

    def _take_over(self, client: Client, number: int) -> str:
        """Read a program up to its dot."""
        lines: list[str] = []
        while len(lines) <= LONGEST_PROGRAM:
            line = client.lines.readline(LONGEST + 2).decode("ascii", "replace").strip()
            if line == ".":
                break
            lines.append(line)
        text = "\n".join(lines)
        program(text)
        self._keep(number, text)
        return f"ok program {number} {len(lines)} lines"

    def _later(self, client: Client) -> None:
        self._say(client, self._wait(WAIT_S))

    def _say(self, client: Client, text: str) -> None:
        if self._faults.value("mute") or self._faults.value("awol"):
            return
        if self._faults.value("slow"):
            time.sleep(self._faults.value("slow"))
        with contextlib.suppress(OSError), client.writing:
            client.line.sendall(text.replace("°", " deg").encode("ascii", "replace") + b"\n")


class Watchdog:
    """Starts the application again where the client is silent, or where nobody comes."""

    def __init__(self, network: Network, silence_s: float, nobody_s: float, restart: Callable[[str], None]) -> None:
        self._network, self._silence, self._nobody, self._restart = network, silence_s, nobody_s, restart
        threading.Thread(target=self._watch, name="watchdog", daemon=True).start()

    def _watch(self) -> None:
        while True:
            time.sleep(0.1)
            quiet = self._network.silent_s
            if self._network.connected and quiet > self._silence:
                self._restart(f"no line for {self._silence:g} s")
            elif not self._network.connected and quiet > self._nobody:
                self._restart(f"nobody connected for {self._nobody:g} s")
