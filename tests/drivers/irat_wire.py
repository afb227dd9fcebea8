"""The iRat's wire as tests speak it by hand: rosbridge frames over one WebSocket."""

import contextlib
import itertools
import json
import threading
import time  # noqa: TID251 - the limit of a wait, and epochs that only grow
from typing import ClassVar

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from robots.kit.clock import FasterTimer
from robots.kit.contract.errors import GrantOver
from tests.waiting import wait_for

FASTER = 2  # times real time: the pace of the shared robot and its driver
CLOCK = FasterTimer(FASTER)

NUMBERS = itertools.count(1)
EPOCHS = itertools.count(2**40 + time.monotonic_ns() // 1000)  # larger than what a fuzzer thinks of


def velocity(linear=0.0, angular=0.0):
    return operation("publish", topic="/irat/cmd_vel", msg={"linear": {"x": linear}, "angular": {"z": angular}})


def operation(op, **fields):
    return json.dumps({"op": op, **fields})


def framed(text):
    """Return a text frame of a WebSocket's client, masked by zeros, with its length in two bytes."""
    data = text.encode()
    return bytes([0x81, 0x80 | 126]) + len(data).to_bytes(2, "big") + bytes(4) + data


class WireClient:
    """A stranger with a WebSocket. What comes beside an answer is kept in `heard`; `clock` is the robot's."""

    OPEN: ClassVar[list] = []

    def __init__(self, sim, open_timeout=10, **options):
        self.line = connect(
            sim.address,
            compression=None,
            open_timeout=open_timeout,
            close_timeout=1,
            max_size=None,
            proxy=None,
            legacy=True,
            **options,
        )
        self.heard, self.clock = [], sim.clock
        self.OPEN.append(self)

    def say(self, op, **fields):
        self.send(operation(op, **fields))

    def send(self, data):
        self.line.send(data)

    def hear(self, accept, seconds=5.0):
        """Return the first frame that `accept` likes."""
        until = time.monotonic() + seconds
        while True:
            frame = json.loads(self.line.recv(timeout=max(0.01, until - time.monotonic())))
            if accept(frame):
                return frame
            self.heard.append(frame)

    def call(self, service, seconds=5.0, **args):
        number = f"by hand {next(NUMBERS)}"
        self.say("call_service", id=number, service=service, args=args)
        return self.hear(lambda frame: frame.get("id") == number, seconds)

    def claim(self, epoch=None):
        return self.call("/irat/claim", epoch=next(EPOCHS) if epoch is None else epoch)["values"]

    def status(self):
        return self.call("/irat/status")["values"]

    def drive(self, linear=0.0, angular=0.0):
        self.send(velocity(linear, angular))

    def send_at_once(self, *frames):
        """Write frames in one go, so that nothing comes between them."""
        self.line.socket.sendall(b"".join(framed(frame) for frame in frames))

    def drive_for(self, seconds, linear=0.0, angular=0.0, every_s=0.1):
        until = self.clock.monotonic() + seconds
        while self.clock.monotonic() < until:
            self.drive(linear, angular)
            self.clock.sleep(every_s)

    def drive_far(self, sim, metres, linear):
        """Drive until the robot has gone so far, however the machine stalls."""
        driven = sim.status()["driven"]

        def far():
            self.drive(linear)
            return sim.status()["driven"] > driven + metres

        wait_for(far, 20, f"{metres} m")

    @contextlib.contextmanager
    def driving(self, **velocity):
        """Drive in a thread meanwhile; whatever happens to the connection."""
        over = threading.Event()

        def work():
            with contextlib.suppress(ConnectionClosed):
                while not over.wait(0.05):  # real time: a hold's rest between two velocities has to be seen
                    self.drive(**velocity)

        thread = threading.Thread(target=work)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()

    def complaint(self, seconds=5.0):
        return self.hear(lambda frame: frame["op"] == "status", seconds)["msg"]

    def newest(self, topic, seconds=5.0):
        """Subscribe, and return the next message."""
        self.say("subscribe", id=topic, topic=topic)
        found = self.hear(lambda frame: frame.get("topic") == topic, seconds)["msg"]
        self.say("unsubscribe", id=topic, topic=topic)
        return found

    def beats(self, number):
        """Let so many messages of the odometry come, 0.05 s of the robot's time one after the other."""
        self.say("subscribe", id="beats", topic="/irat/odom")
        for _ in range(number):
            self.hear(lambda frame: frame.get("topic") == "/irat/odom")
        self.say("unsubscribe", id="beats", topic="/irat/odom")

    def close(self):
        self.line.close()


def journal(sim, event):
    return [record for record in sim.journal() if record["event"] == event]


def until(seconds):
    """Return a permit that ends after so many seconds of the robot's time."""
    end = CLOCK.monotonic() + seconds

    def permit():
        if CLOCK.monotonic() >= end:
            raise GrantOver("The turn is over.")

    return permit
