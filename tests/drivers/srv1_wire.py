"""The hall rover's firmware as tests use it: in virtual time, with its motor board, and with sensors that say what a test says."""

from math import cos, degrees, pi, sin, tau

import numpy as np

from robots.kit.description import load
from robots.kit.drivers.srv1 import answers, extension
from robots.kit.drivers.srv1.framing import ANSWER, Frames
from robots.kit.drivers.srv1.sensors import Channel, share_counts, temperature_counts
from simulators.common.faults import FaultBoard
from simulators.srv1.drive import Drive
from simulators.srv1.firmware import Firmware
from simulators.srv1.imaging import jpeg
from simulators.srv1.stock import AUTORUN, VERSION
from tests.world.world import World

TICK_S = 0.01
BOOT = b"#f" + VERSION + AUTORUN
GREY, ORANGE = (90, 90, 90), (255, 120, 0)
SEEN = np.full((240, 320, 3), GREY, np.uint8)  # a picture of an orange ball, and of noise on the floor
SEEN[60:100, 120:180] = ORANGE
SEEN[200:] += np.random.default_rng(1).integers(0, 60, (40, 320, 3), np.uint8)
JPEG = jpeg(SEEN)


class Bench:
    """A rover whose wheels do what the motor board says, on a floor without slip. See `simulators.srv1.hardware`."""

    def __init__(self, note) -> None:
        body = load("srv1")["body"]
        self._track, self._counts_a_m = body["track"], body["ticks"] / (tau * body["wheel_radius"])
        self.drive, self.faults = Drive(note), FaultBoard()
        self.x, self.y, self.heading = load("srv1")["hall"]["home"]
        self.ways, self.rims, self.now = [0.0, 0.0], (0.0, 0.0), 0.0
        self.near, self.far, self.volts, self.seen = 0.8, 5.0, 7.9, SEEN

    def step(self) -> None:
        self.now += TICK_S
        self.rims = self.drive.step(self.now, TICK_S, self.rims, self.rims == (0.0, 0.0))
        left, right = (rim * TICK_S for rim in self.rims)
        self.ways = [self.ways[0] + left, self.ways[1] + right]
        self.x += (left + right) / 2 * cos(self.heading)
        self.y += (left + right) / 2 * sin(self.heading)
        self.heading += (right - left) / self._track

    def infrared(self) -> float:
        return self.near

    def sonar(self) -> float:
        return self.far

    def analogue(self, channel: int) -> int:
        return {Channel.TEMPERATURE: temperature_counts(21.0), Channel.HUMIDITY: share_counts(0.4)}.get(channel, 0)

    def encoders(self) -> tuple[int, int]:
        left, right = (int(way * self._counts_a_m) for way in self.ways)
        return left, right

    def compass(self) -> float:
        return degrees(pi / 2 - self.heading) % 360

    def battery(self) -> float:
        return self.volts

    def picture(self, width: int) -> np.ndarray | None:
        return self.seen

    def beacon(self) -> None:
        return None


class Rig:
    """The firmware in a world, with its wire in memory; `booted` lets its start pass."""

    def __init__(self, seed: int = 1, booted: bool = True, **options) -> None:
        self.world, self.notes, self.heard, self.frames = World(seed), [], bytearray(), Frames(ANSWER)
        self.bench = Bench(lambda event, **more: self.notes.append((event, more)))
        self.lock = self.world.lock()
        self.firmware = Firmware(
            self.bench, self.hear, self.bench.drive._note, self.world, self.lock, **options
        )  # fmt: skip
        self.world.spawn(self.firmware.run, "firmware")
        self.world.spawn(self._pass, "floor")
        if booted:
            self.pass_s(1.1)
            self.heard.clear()

    def hear(self, data: bytes) -> float:
        self.heard += data
        return 0.0

    def _pass(self) -> None:
        while True:
            self.world.sleep(TICK_S)
            with self.lock:
                self.bench.step()
            self.firmware.tick(self.bench.now)

    def pass_s(self, seconds: float) -> None:
        self.world.sleep(seconds)

    def say(self, data: bytes, seconds: float = 0.05) -> bytes:
        """Send bytes in one piece; return what is answered within that time."""
        self.heard.clear()
        self.firmware.receive(data)
        self.pass_s(seconds)
        return bytes(self.heard)

    def ask(self, command, seconds: float = 0.05):
        """Send a command of ours; return its answer, None if there is none."""
        frames = self.frames.feed(self.say(extension.encode(command), seconds))
        return answers.decode(frames[-1]) if frames else None

    def rest(self) -> str:
        """Let pass what it needs to rest; return how the newest motion ended, as the journal has it."""
        self.pass_s(2.0)
        assert not self.bench.drive.moving
        return [more["end"] for event, more in self.notes if event == "rest"][-1]

    def count(self, event: str) -> int:
        return sum(e == event for e, _ in self.notes)

    def close(self) -> None:
        self.world.close()
