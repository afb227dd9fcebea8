"""A table that turns, asked over a Unix socket with lines of JSON."""

import json
import socket
import threading
from itertools import cycle
from pathlib import Path

from robots.kit.contract.errors import LineGone, MotionHeld
from robots.kit.contract.session import Outcome, Progress, RobotState, Session
from robots.kit.contract.values import check


def angles(kind, args):
    """Where a command leads, one angle (rad) after another; swaying has no end of its own."""
    if kind == "sway":
        return cycle((0.2, -0.2))
    if kind == "tour":
        return [3.0 * (n + 1) / args["stops"] for n in range(int(args["stops"]))]
    return [args["angle"] if kind == "turn" else 0.0]


class Driver(Session):
    closed = False

    def __init__(self, *args):
        super().__init__(*args)
        self._trail, self._key, self._telling = b"", True, threading.Lock()

    def _tell(self, trail):
        """Tell where the table has pointed: all cells, or number and value of those that changed."""
        with self._telling:
            if self._key:
                self._key = self.stream("trail", trail)
            elif changes := [part for i, n in enumerate(trail) if n != self._trail[i] for part in (i, n)]:
                self._key = self.stream("trail", bytes(changes), key=False)
            self._trail = trail

    def _ask(self, **what):
        if self.closed:
            raise LineGone("The turntable is not connected.")
        try:
            with socket.socket(socket.AF_UNIX) as line:
                line.settimeout(5)  # the pace takes a while
                line.connect(Path(self.address).read_text().strip())
                line.sendall(json.dumps(what).encode() + b"\n")
                said = json.loads(line.makefile().readline())
        except (OSError, ValueError) as error:
            raise LineGone(f"The turntable does not answer: {error}.") from error
        angle = said["angle"]
        self._tell(bytes.fromhex(said["trail"]))
        values = {"warmth": said["warmth"], "pace": said["pace"]}
        self.keep(RobotState(self.clock.monotonic(), (angle,), (), said["moving"], True, values=values))
        return said

    def state(self):
        self._ask(do="state")
        return self.latest()

    def connect(self):
        self.closed, self._key = False, True
        return self.state()

    def execute(self, kind, args, permit, on_stage):
        check("turntable", kind, args, self.settings)
        permit()
        if kind == "pace":
            on_stage("sent")
            self._ask(do="pace", pace=args["pace"])  # the table answers when it has taken it over
            on_stage("acknowledged")
            return Outcome(dict(args), self.latest())
        for angle in angles(kind, args):
            permit()
            start = self.state().joints[0]
            self._ask(do="turn", angle=angle)
            on_stage("sent")
            on_stage("acknowledged")
            while (here := self.state()).moving:
                on_stage(Progress(f"at {here.joints[0]:.1f} rad", (here.joints[0] - start) / (angle - start)))
                self.clock.sleep(0.05)
            if self._ask(do="state")["held"]:
                raise MotionHeld("The turntable was stopped on its way.")
        return Outcome(args, self.latest())

    def hold(self):
        self._ask(do="hold")
        return self.latest()

    def close(self):
        self.closed = True
