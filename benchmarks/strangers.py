"""How long a command's answer takes while strangers ask for all they may, beside the same command with nobody there.

Ten sockets of an account that is not cleared and ten of one that is ask for previews as fast as
a socket may; anonymous readers fetch the log's pages one after another. Idle and busy blocks
alternate in one run, so that a slow machine slows both.
"""

import json
import threading
import time
import urllib.request
from collections.abc import Callable
from contextlib import ExitStack, suppress
from datetime import timedelta
from typing import Any

from benchmarks.command_round_trip import cookie
from benchmarks.stage import cast, database, median, percentile, set_up, tell

BLOCKS, EACH = 10, 30  # blocks of each sort; commands a block
SOCKETS, READERS = 10, 2
GOAL = 1.2


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
    """Measure in alternating blocks."""
    set_up()
    with database(), ExitStack() as stack:
        idle, busy, asked = _measure(stack)
    ratio = percentile(busy, 0.99) / percentile(idle, 0.99)
    beside = {
        "idle_ms": round(median(idle), 2), "busy_ms": round(median(busy), 2),
        "idle_99_ms": round(percentile(idle, 0.99), 2), "busy_99_ms": round(percentile(busy, 0.99), 2),
        "asked_by_strangers": asked,
    }  # fmt: skip
    tell("strangers", ratio, "times the idle time of an answer, 99 %", f"<= {GOAL}", ratio <= GOAL, beside)


def _measure(stack: ExitStack) -> tuple[list[float], list[float], int]:
    from accounts.models import Clearance, User
    from robots import services
    from robots.clock import SYSTEM
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
    return (*_alternate(web, person, strangers), strangers.asked)


def _alternate(web: Any, person: Any, strangers: Strangers) -> tuple[list[float], list[float]]:
    from websockets.sync.client import connect

    times: dict[bool, list[float]] = {False: [], True: []}
    address, seq = f"{web.url.replace('http', 'ws')}/ws/robots/mercury/", 0
    with connect(address, additional_headers={"Cookie": cookie(person)}, origin=web.url) as socket:
        for block in range(2 * BLOCKS):
            busy = block % 2 == 1
            strangers.ask(busy)
            for _ in range(EACH):
                seq += 1
                begun = time.perf_counter()
                socket.send(json.dumps({"t": "command", "kind": "noop", "args": {}, "seq": seq}))
                _answered(socket, seq)
                times[busy].append((time.perf_counter() - begun) * 1000)
                time.sleep(0.055)
    return times[False], times[True]


def _answered(socket: Any, seq: int) -> None:
    while True:
        data = socket.recv(timeout=10)
        if isinstance(data, str) and (said := json.loads(data))["t"] == "answer" and said["seq"] == seq:
            assert said["ok"], said
            return


if __name__ == "__main__":
    main()
