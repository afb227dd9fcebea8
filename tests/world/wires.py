"""Wires in memory between a robot's driver and its simulator, with what happens to real ones."""

from collections.abc import Callable
from pathlib import Path

import serial

from robots.kit.clock import Timer
from simulators.common.faults import FaultBoard
from simulators.common.serial_line import Line
from tests.world.world import World

READ_S = 1.0


class Wire:
    """The faults of a wire: it is pulled, it stalls, and it loses the rest of a message."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.plugged, self._stalled_until, self.kept_back_s = True, 0.0, 0.0
        self._halved = False

    def pull(self) -> None:
        """Pull the plug: bytes on their way are lost, and its user is told."""
        self.world.note("the cable was pulled")
        self.plugged = False
        self.lose()

    def lose(self) -> None:
        """Lose what is on its way."""
        raise NotImplementedError

    def plug(self) -> None:
        self.world.note("the cable was plugged in")
        self.plugged = True

    def stall(self, seconds: float) -> None:
        """Carry nothing for so long; it arrives then."""
        self.world.note(f"the cable stalled for {seconds:.3f} s")
        self._stalled_until, self.kept_back_s = self.world.monotonic() + seconds, seconds

    def halve(self) -> None:
        """Carry the first half of the next message to the robot, and lose the other."""
        self.world.note("half of the next message is lost")
        self._halved = True

    def cut(self, data: bytes) -> bytes:
        """Return what is carried of a message to the robot."""
        if self._halved:
            data, self._halved = data[: len(data) // 2], False
        return data

    @property
    def carries(self) -> bool:
        return self.plugged and self.world.monotonic() >= self._stalled_until


class Cable(Wire):
    """Two directions of bytes: `to_robot` and `to_host`."""

    def __init__(self, world: World) -> None:
        super().__init__(world)
        self.to_robot, self.to_host = bytearray(), bytearray()

    def lose(self) -> None:
        self.to_robot.clear()
        self.to_host.clear()

    def send(self, data: bytes) -> None:
        """Take what the host writes."""
        data = self.cut(data)
        if self.plugged:
            self.to_robot += data

    def taken(self, buffer: bytearray, most: int) -> bytes:
        """Take bytes that have arrived."""
        if not self.carries:
            return b""
        data = bytes(buffer[:most])
        del buffer[:most]
        return data


class Port:
    """The host's end, as pyserial's ports are used."""

    def __init__(self, cable: Cable, sent: Callable[[bytes], None]) -> None:
        self._sent = sent  # told of each message
        if not cable.plugged:
            raise serial.SerialException(2, "No such file or directory")
        self._cable, self._open = cable, True
        cable.world.running.process.at_kill.append(self.close)

    def _check(self) -> None:
        if not self._open or not self._cable.plugged:
            raise serial.SerialException("device disconnected")

    @property
    def in_waiting(self) -> int:
        self._check()
        return len(self._cable.to_host) if self._cable.carries else 0

    def read(self, most: int) -> bytes:
        cable, world = self._cable, self._cable.world
        self._check()
        world.park(
            world.monotonic() + READ_S,
            lambda: not self._open or not cable.plugged or (cable.carries and cable.to_host),
        )
        return b"" if not self._open else self._read(most)

    def _read(self, most: int) -> bytes:
        self._check()
        return self._cable.taken(self._cable.to_host, most)

    def write(self, data: bytes) -> None:
        self._check()
        self._sent(data)
        self._cable.send(data)

    def cancel_read(self) -> None:
        self._open = False

    def close(self) -> None:
        self._open = False


def line_of(cable: Cable, baud: int) -> Callable[[Path, FaultBoard, Callable[[], None]], Line]:
    """Return what opens the robot's end of a serial line."""

    class End(Line):
        def _open(self, link: Path) -> None:
            pass

        def _write(self, data: bytes) -> None:
            if cable.plugged:
                cable.to_host += data

        def _receive(self, most: int) -> bytes:
            return cable.taken(cable.to_robot, most)

        def wait(self, timeout: float, /) -> bool:
            return cable.carries and bool(cable.to_robot)

    def opened(tty: Path, faults: FaultBoard, refused: Callable[[], None], clock: Timer = cable.world) -> Line:
        return End(tty, faults, baud, clock)

    return opened
