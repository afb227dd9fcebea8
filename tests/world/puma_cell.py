"""The PUMA 560 in a world: its simulator, and a host that speaks the wire by hand."""

from pathlib import Path

from robots.kit.drivers.puma import protocol as wire
from robots.kit.drivers.puma.protocol import BAUDS, CLOCK, Error, Frame, Instruction, Mode, State
from simulators.puma.simulator import Simulator
from tests.world.puma import InPlace
from tests.world.wires import Cable, line_of
from tests.world.world import World

FRESH_S = 0.9
SEED = 3  # of the cell's hidden errors


class Cell:
    """A simulated arm in a process of its own, and a host at the other end of its line."""

    def __init__(self, world: World, folder: Path, baud: int = BAUDS[-1]) -> None:
        self.world, self.folder, self.baud = world, folder, baud
        self.cable = Cable(world)
        self._receiver = wire.Receiver(wire.REPLIES)
        self._heard: list[Frame] = []
        self.seq = 0
        self.start()

    def start(self) -> None:
        """Begin a process with a simulator."""
        self.process = self.world.process("simulator", delayed=False)
        self.planner = InPlace(self.world)
        line = line_of(self.cable, self.baud)
        self.sim = Simulator(self.folder, lambda note: self.planner, line, SEED, self.world, self.world)
        self.world.spawn(self.sim.run, "simulator", self.process)

    def send(self, what: int, *numbers: int, seq: int | None = None) -> int:
        """Send an instruction, under the next number unless one is given; return its number."""
        if seq is None:
            seq = self.seq = (self.seq + 1) % wire.SEQUENCES
        self.cable.send(Frame(what, seq, numbers).encode())
        return seq

    def answer(self, seq: int, within_s: float = 1.0) -> Frame:
        """Wait for the answer to a number."""

        def found():
            self._heard += self._receiver.feed(self.cable.taken(self.cable.to_host, 9999))
            return next((frame for frame in self._heard if frame.seq == seq), None)

        answer = self.world.until(found, within_s, f"the answer to {seq}")
        self._heard.clear()
        return answer

    def ask(self, what: int, *numbers: int, seq: int | None = None) -> Error | None:
        """Send an instruction; return why it is refused, None if it is not."""
        answer = self.answer(self.send(what, *numbers, seq=seq))
        return None if answer.id == wire.Reply.ACK else wire.error_of(answer)

    def state(self) -> State:
        return State.of(self.answer(self.send(Instruction.STATUS)))

    def latest(self, seconds: float = FRESH_S) -> int:
        """Return the controller's clock in so many seconds."""
        return (self.state().clock + round(seconds / wire.TICK_S)) % CLOCK

    def move(self, what: int, *numbers: int) -> Error | None:
        """Send a motion that may begin for a while; return why it is refused at once."""
        return self.ask(what, self.latest(), *numbers)

    def at_rest(self, within_s: float = 15.0) -> State:
        """Ask for states until the arm does nothing; return the last one."""
        until = self.world.monotonic() + within_s
        while (state := self.state()).mode != Mode.IDLE:
            assert self.world.monotonic() < until, state
            self.world.sleep(0.05)
        return state

    def calibrate(self) -> None:
        assert self.move(Instruction.CALIBRATE) is None
        self.at_rest()

    def count(self, event: str) -> int:
        return self.sim.journal.counts[event]

    @property
    def q(self):
        """Return what the encoders measure (rad)."""
        return self.sim.plant.measured().q
