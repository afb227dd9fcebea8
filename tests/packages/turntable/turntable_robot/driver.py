"""A table that turns, asked over a Unix socket with lines of JSON."""

import json
import socket
import time
from pathlib import Path

from robots.drivers.contract import Argument, CommandKind, Features, Outcome, RobotState
from robots.drivers.errors import Held, LineGone
from robots.drivers.values import known, number, within


class Driver:
    def __init__(self, address, settings, trace=None):
        self.features = Features(
            name="Turntable",
            joints=("table",),
            handover=("home",),
            commands=(
                CommandKind("turn", "Turn", (Argument("angle", "rad", -3.0, 3.0),)),
                CommandKind("home", "Home"),
            ),
        )
        self._address, self._latest, self._open = Path(address), None, False

    def _ask(self, **what):
        try:
            with socket.socket(socket.AF_UNIX) as line:
                line.settimeout(1)
                line.connect(self._address.read_text().strip())
                line.sendall(json.dumps(what).encode() + b"\n")
                said = json.loads(line.makefile().readline())
        except (OSError, ValueError) as error:
            raise LineGone(f"The turntable does not answer: {error}.") from error
        self._latest = RobotState(
            time.monotonic(), (said["angle"],), (0.0, 0.0, 0.0, said["angle"]), said["moving"], True
        )
        return said

    def connect(self):
        return self.state()

    def close(self):
        pass

    def state(self):
        self._ask(do="state")
        return self._latest

    def latest(self):
        return self._latest

    def check(self, kind, args, pose=None):
        within(known(self.features, kind, args), args)

    def execute(self, kind, args, permit, on_stage):
        self.check(kind, args)
        permit()
        self._ask(do="turn", angle=number(args, "angle") if kind == "turn" else 0.0)
        on_stage("sent")
        on_stage("acknowledged")
        while self.state().moving:
            time.sleep(0.05)
        if self._ask(do="state")["held"]:
            raise Held("The turntable was stopped on its way.")
        return Outcome(dict(args), self._latest)

    def hold(self):
        self._ask(do="hold")
        return self._latest

    def recover(self, permit):
        return self.state()
