"""A cart on a rail, asked over a Unix socket with lines of JSON."""

import json
import socket
from pathlib import Path

import cv2
import numpy as np

from robots.kit.contract.errors import BadRequest, GaveUp, LineGone, MotionHeld
from robots.kit.contract.session import Outcome, RobotState, Session
from robots.kit.contract.values import check

BROKEN_RAIL, LEAF = 1.75, 1.25  # m: places that it cannot serve


class Driver(Session):
    closed = False

    def _ask(self, **what):
        if self.closed:
            raise LineGone("The shuttle is not connected.")
        try:
            with socket.socket(socket.AF_UNIX) as line:
                line.settimeout(5)
                line.connect(Path(self.address).read_text().strip())
                line.sendall(json.dumps(what).encode() + b"\n")
                said = json.loads(line.makefile().readline())
        except (OSError, ValueError) as error:
            raise LineGone(f"The shuttle does not answer: {error}.") from error
        values = {"battery": said["battery"], "driven": said["driven"], "rail": said["rail"]}
        self.keep(RobotState(self.clock.monotonic(), (said["x"],), (said["x"],), said["moving"], True, values=values))
        return said

    def state(self):
        self._ask(do="state")
        return self.latest()

    def connect(self):
        self.closed = False
        return self.state()

    def execute(self, kind, args, permit, on_stage):
        check("shuttle", kind, args, self.settings)
        if args.get("x") == BROKEN_RAIL:
            raise BadRequest("The rail ends before this place today.")
        permit()
        self._ask(do=kind, **args)
        on_stage("sent")
        on_stage("acknowledged")
        while self.state().moving:
            self.clock.sleep(0.02)
        if self._ask(do="state")["held"]:
            raise MotionHeld("The shuttle was stopped on its way.")
        if args.get("x") == LEAF:
            raise GaveUp("A leaf lies on the rail here.")
        return Outcome(args, self.latest())

    def picture(self, view, seconds):
        """Draw what a camera above the rail would see."""
        rail = np.full((16, 128), 60, np.uint8)
        rail[4:12, int(60 * self.state().joints[0]) :][:, :8] = 220
        return cv2.imencode(".png", rail)[1].tobytes()

    def hold(self):
        self._ask(do="hold")
        return self.latest()

    def close(self):
        self.closed = True
