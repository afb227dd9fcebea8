"""The SO-101's six servos on their line, as a process: ``python -m simulators.so101 --dir DIR [--speed FACTOR]``.

Feetech's protocol as STS3215 servos speak it: ``FF FF id length instruction parameters checksum``, answered by
``FF FF id length error parameters checksum``; each servo has a table of registers, little-endian. In DIR it keeps `tty`
(the line), `calibration/farhand.json` (as LeRobot stores that of a real arm), `faults` (a Unix socket) and
`journal.jsonl`.
"""

import json
import select
import threading
from pathlib import Path
from typing import Any

from robots.kit.clock import TIMER, FasterTimer, Timer
from robots.kit.files import replace_text
from simulators.common.faults import FaultBoard, serve
from simulators.common.journal import Journal
from simulators.common.process import arguments, run
from simulators.common.terminal import Terminal
from simulators.common.threads import end_with_any, record_deaths

NAMES = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")
TURN = 4096  # ticks
MIDDLE = 2047  # ticks, of every calibrated range
RANGE, OF_ROLL = (700, 3395), (200, 3895)  # ticks: calibrated ranges; the wrist rolls almost all the way round
MODEL, FIRMWARE = 777, (3, 10)
EVERYBODY = 0xFE
REGISTERS = 128  # bytes
PING, READ, WRITE, SYNC_READ, SYNC_WRITE = 1, 2, 3, 0x82, 0x83
MIN_LIMIT, MAX_LIMIT, TORQUE, GOAL, POSITION, SPEED, MOVING = 9, 11, 40, 42, 56, 58, 66
STEP_S = 0.004
STIFFNESS, FASTEST, QUICKEST = 18.0, 3000.0, 30_000.0  # 1/s, ticks/s, ticks/s2
ARRIVED = 2.0  # ticks


def range_of(number: int) -> tuple[int, int]:
    """Return the calibrated range of a servo (ticks)."""
    return OF_ROLL if NAMES[number - 1] == "wrist_roll" else RANGE


class Servo:
    """One servo: its registers, and a motor that moves to its goal."""

    def __init__(self, number: int, at: float) -> None:
        low, high = range_of(number)
        self.registers = bytearray(REGISTERS)
        self.registers[0:2] = bytes(FIRMWARE)
        self.registers[5] = number
        for address, value in ((3, MODEL), (MIN_LIMIT, low), (MAX_LIMIT, high), (GOAL, round(at))):
            self.put(address, value)
        self.at, self.speed = at, 0.0
        self.step()

    def put(self, address: int, value: int) -> None:
        """Write a register of two bytes."""
        self.registers[address : address + 2] = value.to_bytes(2, "little")

    def get(self, address: int) -> int:
        """Read a register of two bytes."""
        return int.from_bytes(self.registers[address : address + 2], "little")

    def write(self, address: int, data: bytes) -> None:
        """Take written registers; when torque is switched on, the motor holds its present position."""
        was = self.registers[TORQUE]
        self.registers[address : address + len(data)] = data
        if self.registers[TORQUE] and not was:
            self.put(GOAL, round(self.at))

    def step(self) -> None:
        """Advance by one step."""
        wanted = 0.0
        if self.registers[TORQUE]:
            goal = min(max(self.get(GOAL), self.get(MIN_LIMIT)), self.get(MAX_LIMIT))
            wanted = min(max((goal - self.at) * STIFFNESS, -FASTEST), FASTEST)
        change = QUICKEST * STEP_S
        self.speed += min(max(wanted - self.speed, -change), change)
        self.at += self.speed * STEP_S
        self.put(POSITION, round(self.at))
        self.put(SPEED, min(round(abs(self.speed)), 0x7FFF) | (0x8000 if self.speed < 0 else 0))
        self.registers[MOVING] = int(abs(self.speed) > ARRIVED)


class Simulator:
    """Six servos and their line."""

    def __init__(self, folder: Path, clock: Timer = TIMER) -> None:
        (folder / "calibration").mkdir(parents=True, exist_ok=True)
        self.faults, self.journal = FaultBoard(), Journal(folder / "journal.jsonl")
        record_deaths(self.journal)
        self._folder, self._clock = folder, clock
        self._servos = {n: Servo(n, at) for n, at in zip(range(1, 7), self._kept(), strict=True)}
        self._rest = b""
        self._lock = threading.Lock()
        self._running, self._moves = True, False
        serve(folder / "faults", self.faults, self.status)
        self._calibrated()
        self._terminal = Terminal(folder / "tty")

    def _kept(self) -> list[float]:
        try:
            kept = [float(v) for v in json.loads((self._folder / "places.json").read_text())]
        except (OSError, ValueError, TypeError, OverflowError):
            kept = []
        whole = len(kept) == len(NAMES) and all(0 <= v < TURN for v in kept)
        return kept if whole else [float(MIDDLE)] * len(NAMES)

    def _calibrated(self) -> None:
        kept = {
            name: {"id": n, "drive_mode": 0, "homing_offset": 0, "range_min": low, "range_max": high}
            for n, name in enumerate(NAMES, 1)
            for low, high in (range_of(n),)
        }
        replace_text(self._folder / "calibration" / "farhand.json", json.dumps(kept))

    def status(self) -> dict[str, Any]:
        """Return positions (ticks), goals and counters, for tests."""
        return {
            "counts": dict(self.journal.counts),
            "ticks": [round(s.at, 1) for s in self._servos.values()],
            "goals": [s.get(GOAL) for s in self._servos.values()],
            "moving": self._moves,
        }

    def run(self) -> None:
        """Serve the line and move the servos until stopped."""
        threading.Thread(target=self._drive, name="motors", daemon=True).start()
        while self._running:
            ready, _, _ = select.select([self._terminal.number], [], [], 0.2)  # real time
            if ready:
                try:
                    self._take(self._terminal.read(4096))
                except OSError:
                    self._clock.sleep(0.05)
        replace_text(self._folder / "places.json", json.dumps([s.at for s in self._servos.values()]))

    def stop(self, *_: object) -> None:
        """End the loop."""
        self._running = False

    def _drive(self) -> None:
        due = self._clock.monotonic()
        while self._running:
            due = max(due + STEP_S, self._clock.monotonic() - 0.1)
            self._clock.sleep(due - self._clock.monotonic())
            with self._lock:
                for servo in self._servos.values():
                    servo.step()
                moves = any(s.registers[MOVING] for s in self._servos.values())
            if moves != self._moves:
                self._moves = moves
                self.journal.note("motion" if moves else "rest", goals=[s.get(GOAL) for s in self._servos.values()])

    def _take(self, data: bytes) -> None:
        self._rest += data
        while True:
            begin = self._rest.find(b"\xff\xff")
            self._rest = self._rest[begin:] if begin >= 0 else self._rest[-1:]
            if len(self._rest) < 6 or len(self._rest) < 4 + self._rest[3]:
                return
            packet, self._rest = self._rest[2 : 4 + self._rest[3]], self._rest[4 + self._rest[3] :]
            if sum(packet) & 0xFF != 0xFF:
                self.journal.note("bad_checksum")
            elif why := self._why_not(packet[2:-1]):
                self.journal.note("refused", why=why)
            else:
                with self._lock:
                    self._obey(packet[0], packet[2], packet[3:-1])

    @staticmethod
    def _why_not(said: bytes) -> str:
        """Return why an instruction with its parameters is ignored, or an empty text."""
        if not said:
            return "no instruction"
        instruction, data = said[0], said[1:]
        if instruction in (READ, WRITE, SYNC_READ, SYNC_WRITE):
            if len(data) < 2:
                return "too few parameters"
            length = {WRITE: len(data) - 1, SYNC_WRITE: data[1]}.get(instruction, 0)
            if data[0] + length > REGISTERS:
                return "past the last register"
        return ""

    def _obey(self, number: int, instruction: int, data: bytes) -> None:
        who = list(self._servos) if number == EVERYBODY else [n for n in (number,) if n in self._servos]
        if instruction == PING:
            for n in who:
                self._answer(n, b"")
        elif instruction == READ:
            for n in who:
                self._answer(n, bytes(self._servos[n].registers[data[0] : data[0] + data[1]]))
        elif instruction == WRITE:
            for n in who:
                self._servos[n].write(data[0], data[1:])
                if number != EVERYBODY:
                    self._answer(n, b"")
        elif instruction == SYNC_READ:
            for n in data[2:]:
                if n in self._servos:
                    self._answer(n, bytes(self._servos[n].registers[data[0] : data[0] + data[1]]))
        elif instruction == SYNC_WRITE:
            self._write_all(data)

    def _write_all(self, data: bytes) -> None:
        address, length, rows = data[0], data[1], data[2:]
        for k in range(0, len(rows) - length, length + 1):
            if rows[k] in self._servos:
                self._servos[rows[k]].write(address, rows[k + 1 : k + 1 + length])
        if address == GOAL:
            self.journal.note("goal", goals=[s.get(GOAL) for s in self._servos.values()])

    def _answer(self, number: int, data: bytes) -> None:
        if self.faults.value("mute") or self.faults.chance("drop"):
            return
        body = bytes([number, len(data) + 2, 0]) + data
        packet = bytearray(b"\xff\xff" + body + bytes([~sum(body) & 0xFF]))
        if self.faults.chance("corrupt"):
            packet[-1] ^= 0x10
        self._clock.sleep(self.faults.value("slow"))
        self._terminal.write(bytes(packet))


def main() -> None:
    """Run the simulator."""
    end_with_any()
    options = arguments(__doc__).parse_args()
    simulator = Simulator(options.dir, FasterTimer(options.speed))
    run(simulator, f"line {options.dir / 'tty'}")


if __name__ == "__main__":
    main()
