"""How long the answers to a command and to Stop take while strangers do all they can.

Ten sockets of an account that is not cleared and ten of one that is ask for previews as fast as
a socket may; anonymous readers fetch the log's pages one after another. Idle and busy blocks
alternate in one run, so that a slow machine slows both. Then one crowd after another
attacks with its own connections (`benchmarks/_attackers.py`).
"""

import json
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from datetime import timedelta
from pathlib import Path
from typing import Any

from benchmarks._attackers import CROWDS
from benchmarks.command_round_trip import cookie
from benchmarks.stage import cast, database, median, percentile, set_up, tell

BLOCKS, EACH = 10, 30  # blocks of each sort; commands a block
SOCKETS, READERS = 10, 2
GOAL = 1.2
STOPS, PAUSE_S = 120, 0.06  # beside each crowd; between two messages of a socket that may send thirty a second
GOAL_MS = 300  # 99 % of the answers to a command and to Stop, beside each crowd


class Strangers:
    """Threads that ask while `busy` is set."""

    def __init__(self, web: Any, cookies: list[str]) -> None:
        self._web, self._busy, self._over = web, threading.Event(), threading.Event()
        self.asked = 0
        jobs: list[Callable[[], None]] = [self._reader] * READERS
        jobs += [lambda c=c: self._planner(c) for c in cookies for _ in range(SOCKETS)]  # type: ignore[misc]
        self._threads = [threading.Thread(target=job, daemon=True) for job in jobs]
        for thread in self._threads:
            thread.start()

    def _planner(self, header: str) -> None:
        from websockets.sync.client import connect

        address = f"{self._web.url.replace('http', 'ws')}/ws/robots/mercury/"
        ask = json.dumps({"t": "plan", "kind": "move", "args": {"x": 0.01, "y": 0.43}, "from": [0, 0, 0, 0], "n": 1})
        while not self._over.is_set():
            self._busy.wait(1)
            with (
                suppress(Exception),
                connect(address, additional_headers={"Cookie": header}, origin=self._web.url) as socket,
            ):
                while self._busy.is_set():
                    socket.send(ask)
                    self.asked += 1
                    with suppress(TimeoutError):
                        socket.recv(timeout=0.04)  # under the socket's limit of 30 a second

    def _reader(self) -> None:
        while not self._over.is_set():
            if not self._busy.wait(1):
                continue
            with suppress(OSError):
                urllib.request.urlopen(f"{self._web.url}/log/?q=sand&page=1", timeout=10).read()
                self.asked += 1

    def ask(self, busy: bool) -> None:
        """Begin, or end."""
        (self._busy.set if busy else self._busy.clear)()
        time.sleep(1.5)

    def end(self) -> None:
        """End for good."""
        self._busy.clear()
        self._over.set()


def main() -> None:
    """Measure in alternating blocks, then beside each crowd."""
    set_up()
    with database(), ExitStack() as stack:
        idle, busy, asked, crowds = _measure(stack)
    ratio = percentile(busy, 0.99) / percentile(idle, 0.99)
    slowest = max(max(crowd["command_99_ms"], crowd["stop_99_ms"]) for crowd in crowds.values())
    beside = {
        "idle_ms": round(median(idle), 2), "busy_ms": round(median(busy), 2),
        "idle_99_ms": round(percentile(idle, 0.99), 2), "busy_99_ms": round(percentile(busy, 0.99), 2),
        "asked_by_strangers": asked, "crowds": crowds,
    }  # fmt: skip
    goal = f"<= {GOAL}, and {GOAL_MS} ms for a command and Stop, 99 %, beside each crowd"
    tell(
        "strangers", ratio, "times the idle time of an answer, 99 %", goal, ratio <= GOAL and slowest <= GOAL_MS, beside
    )


def _measure(stack: ExitStack) -> tuple[list[float], list[float], int, dict[str, dict[str, float]]]:
    from accounts.models import Clearance, User
    from robots import services
    from robots.kit.clock import SYSTEM
    from robots.models import Robot
    from robots.states import Cycle, GrantKind
    from tests.conftest import RedisServer, wait_for
    from tests.rig import Simulator, Web, worker

    redis = RedisServer()
    redis.start()
    stack.callback(redis.stop)
    robot, person = cast()
    for made in (Simulator(robot.rig_dir),):
        stack.callback(made.stop)
    for child in (worker(), web := Web()):
        stack.callback(child.kill)
    wait_for(lambda: Robot.objects.get().cycle == Cycle.READY, 60, "the robot")
    Robot.objects.update(cycle=Cycle.OPERATING)
    now = SYSTEM.now()
    services.start_grant(robot, GrantKind.TURN, now, person, now + timedelta(minutes=30))
    eve, bob = (User.objects.create_user(name, f"{name}@example.org", "correct horse 42") for name in ("eve", "bob"))
    Clearance.objects.create(user=bob, robot=robot, granted_at=now)
    strangers = Strangers(web, [cookie(eve), cookie(bob)])
    stack.callback(strangers.end)
    with operator(web, person) as socket:
        idle, busy = _alternate(socket, strangers)
        strangers.ask(False)
        return idle, busy, strangers.asked, {name: _beside(name, web, socket) for name in CROWDS}


class Operator:
    """The socket of the person who drives."""

    def __init__(self, socket: Any) -> None:
        self._socket, self._seq = socket, 0

    def ask(self, message: dict[str, Any]) -> float:
        """Send a message; return after how many ms it was answered, and pause."""
        begun = time.perf_counter()
        self._socket.send(json.dumps(message))
        while True:
            data = self._socket.recv(timeout=60)
            if (
                isinstance(data, str)
                and (said := json.loads(data))["t"] == "answer"
                and said["seq"] == message.get("seq")
            ):
                assert said["ok"], said
                break
        took = (time.perf_counter() - begun) * 1000
        time.sleep(PAUSE_S)
        return took

    def command(self) -> float:
        """Send a command that moves nothing; return after how many ms it was answered."""
        self._seq += 1
        return self.ask({"t": "command", "kind": "noop", "args": {}, "seq": self._seq})


@contextmanager
def operator(web: Any, person: Any) -> Iterator[Operator]:
    """Connect as the person who drives."""
    from websockets.sync.client import connect

    address = f"{web.url.replace('http', 'ws')}/ws/robots/mercury/"
    with connect(address, additional_headers={"Cookie": cookie(person)}, origin=web.url) as socket:
        yield Operator(socket)


def _alternate(socket: Operator, strangers: Strangers) -> tuple[list[float], list[float]]:
    times: dict[bool, list[float]] = {False: [], True: []}
    for block in range(2 * BLOCKS):
        busy = block % 2 == 1
        strangers.ask(busy)
        times[busy] += [socket.command() for _ in range(EACH)]
    return times[False], times[True]


def _beside(crowd: str, web: Any, socket: Operator) -> dict[str, float]:
    attackers = [sys.executable, "-m", "benchmarks._attackers", crowd, str(web.port)]
    commands, stops, most = [], [], 0.0
    with subprocess.Popen(attackers, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin and process.stdout
        process.stdout.readline()
        for _ in range(STOPS):
            commands.append(socket.command())
            stops.append(socket.ask({"t": "stop"}))
            socket.ask({"t": "release", "checked": True})
            most = max(most, resident_mb(web.process.pid))
        process.stdin.close()
    return {
        "connections": CROWDS[crowd][1], "command_99_ms": round(percentile(commands, 0.99)),
        "stop_99_ms": round(percentile(stops, 0.99)), "web_mb": round(most),
    }  # fmt: skip


def resident_mb(pid: int) -> float:
    """Return a process's resident memory in MB."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.partition("VmRSS:")[2].split()[0]) / 1000


if __name__ == "__main__":
    main()
