"""A rosbridge in memory: connections between hosts and a robot's radio, with what happens to real ones."""

import math
from collections import deque
from collections.abc import Callable, Iterator

from robots.kit.drivers.rosbridge_client import OPEN_S
from simulators.common.faults import FaultBoard
from simulators.irat.peer import Peer
from simulators.irat.radio import Radio
from tests.world.world import Process, World


class Network:
    """Carries frames. Connections can be cut, new ones refused, and frames kept back."""

    def __init__(self, world: World, radio: Radio, faults: FaultBoard, robot: Process) -> None:
        self.world, self.radio, self.faults = world, radio, faults
        self.lines: list[Line] = []
        self.opened, self.plugged, self.halved = 0, True, False
        self._stalled_until = self.kept_back_s = 0.0
        world.spawn(self._serve, "radio", robot)

    def open(self, address: str, sent: Callable[[str], None] = lambda frame: None) -> "Line":
        """Connect a host; a robot whose radio is silent answers no handshake. `sent` is told of each of its frames."""
        self._check()
        if not self.world.park(self.world.monotonic() + OPEN_S, lambda: not self.radio.silent):
            raise TimeoutError("timed out during opening handshake")
        self._check()
        self.opened += 1
        return Line(self, sent)

    def _check(self) -> None:
        if not self.plugged:
            raise ConnectionRefusedError(111, "Connection refused")

    def cut(self) -> None:
        """End every connection; frames on their way are lost."""
        self.world.note("the connections were cut")
        for line in self.lines:
            line.to_robot.clear()
            line.close()

    def pull(self) -> None:
        """End every connection, and refuse new ones until `plug`."""
        self.plugged = False
        self.cut()

    def plug(self) -> None:
        self.world.note("the network is there again")
        self.plugged = True

    def stall(self, seconds: float) -> None:
        """Carry nothing for so long; it arrives then."""
        self.world.note(f"the network stalled for {seconds:.3f} s")
        self._stalled_until, self.kept_back_s = self.world.monotonic() + seconds, seconds

    def halve(self) -> None:
        """End the connection in the middle of the next message to the robot."""
        self.world.note("half of the next message is lost")
        self.halved = True

    @property
    def carries(self) -> bool:
        return self.world.monotonic() >= self._stalled_until

    def _some(self) -> bool:
        return self.carries and any(line.ended or line.to_robot for line in self.lines)

    def _serve(self) -> None:
        """Hand to the radio what arrives, in the robot's process."""
        while True:
            self.world.park(math.inf, self._some)
            for line in list(self.lines):
                while line.to_robot:
                    line.peer.heard_at = self.world.monotonic()
                    self.radio.take(line.peer, line.to_robot.popleft())
                if line.ended:
                    self.lines.remove(line)
                    self.radio.leave(line.peer)


class Line:
    """The host's end of a connection, as `rosbridge_client.Connection`; it ends with the host's process."""

    def __init__(self, network: Network, sent: Callable[[str], None]) -> None:
        self._network, self._world, self._sent, self.ended = network, network.world, sent, False
        self.to_robot: deque[str] = deque()
        self.peer = Peer(f"host:{network.opened}", network.faults, lambda: None, self.close, network.world)
        network.lines.append(self)
        network.radio.join(self.peer)
        network.world.running.process.at_kill.append(self.close)

    def send(self, frame: str) -> None:
        if self.ended:
            raise ConnectionResetError(104, "Connection reset by peer")
        self._sent(frame)
        if self._network.halved:
            self._network.halved = False
            self.close()
        else:
            self.to_robot.append(frame)

    def __iter__(self) -> Iterator[str]:
        while not self.ended:
            self._world.park(math.inf, lambda: self.ended or (self._network.carries and self.peer.waits))
            if not self.ended and (frame := self.peer.next()) is not None:
                if self.peer.slow_s:
                    self._world.sleep(self.peer.slow_s)
                yield frame

    def close(self) -> None:
        self.ended = True
