"""The museum arm's wire as tests use it: a terminal, and the simulator's journal."""

import contextlib
import socket
from typing import ClassVar

from robots.kit.clock import FasterTimer
from tests.waiting import wait_for

FASTER = 4  # times real time: the pace of the shared arm and its driver
CLOCK = FasterTimer(FASTER)


def allow():
    """Permit everything."""


def do(driver, kind, **args):
    return driver.execute(kind, args, allow, lambda _: None)


def journal(sim, event, since=0.0):
    return [r for r in sim.journal() if r["event"] == event and r["t"] >= since]


class Terminal:
    """A text terminal on the controller's line."""

    OPEN: ClassVar[list] = []

    def __init__(self, sim):
        self.OPEN.append(self)
        host, _, port = (sim.folder / "tty").read_text().strip().partition(":")
        self.socket = socket.create_connection((host, int(port)), timeout=120)
        self.lines = self.socket.makefile("rb")

    def say(self, *lines):
        self.socket.sendall("".join(f"{line}\n" for line in lines).encode())

    def hear(self):
        return self.lines.readline().decode().strip()

    def ask(self, line):
        self.say(line)
        return self.hear()

    def close(self):
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)
        self.lines.close()
        self.socket.close()


def push_out(terminal, sim):
    """Have the arm pushed beyond the range of its first axis, without a motion of its own."""
    assert terminal.ask("j 160 -40 -40 0 -30 0 1").startswith("ok")
    assert terminal.ask("W") == "a"
    sim.fault("disturb", 900.0)
    wait_for(lambda: terminal.ask("w") == "e", 10, "the range error")
    sim.clear()
    wait_for(lambda: abs(sim.status()["speed"]) < 0.01, 10, "rest")
