"""Connections in memory, as TCP's: two directions of bytes, in order, each with an end; and who listens for them."""

import math
from collections import deque
from collections.abc import Callable

from tests.world.wires import Wire
from tests.world.world import World


class Network(Wire):
    """What lies between owners and one robot that listens.

    Pulled, it resets every connection and refuses new ones, as a switch does whose power is cut beside it. While it
    stalls nothing arrives, neither bytes nor the end of a connection, and nobody is told. A message that it halves is
    the last of its connection. There are no keep-alive probes: a stall ends no connection by itself.
    """

    def __init__(self, world: World) -> None:
        super().__init__(world)
        self.waiting: deque[Connection] = deque()  # not yet accepted
        self.connections: list[Connection] = []
        self.listens, self.opened = False, 0

    def lose(self) -> None:
        for connection in self.connections:
            connection.reset = True
        self.connections.clear()
        self.waiting.clear()

    def connect(self, host: str, port: int, seconds: float, sent: Callable[[bytes], None] = lambda data: None) -> "End":
        """Open a connection from the process that runs; return its end there. Raises OSError.

        `sent` is told of each message that this end sends.
        """
        if not self.world.park(self.world.monotonic() + seconds, lambda: self.carries or not self.plugged):
            raise TimeoutError("timed out")
        if not self.plugged:
            raise OSError(113, "No route to host")
        if not self.listens:
            raise ConnectionRefusedError(111, "Connection refused")
        self.opened += 1
        made = Connection(self, self.opened, sent)
        self.connections.append(made)
        self.waiting.append(made)
        self.world.running.process.at_kill.append(made.host.close)
        return made.host


class Connection:
    """One connection; `reset` once it is broken."""

    def __init__(self, network: Network, number: int, sent: Callable[[bytes], None]) -> None:
        self.network, self.number, self.sent, self.reset = network, number, sent, False
        to_robot, to_host = Way(), Way()
        self.host = End(self, to_host, to_robot, of_host=True)
        self.robot = End(self, to_robot, to_host)


class Way:
    """Bytes on their way in one direction, and whether no more will come."""

    def __init__(self) -> None:
        self.bytes, self.ended = bytearray(), False


class End:
    """One end of a connection: a driver's `Stream`, and a simulator's `Line`."""

    def __init__(self, connection: Connection, comes: Way, goes: Way, of_host: bool = False) -> None:
        self._connection, self._comes, self._goes, self._of_host = connection, comes, goes, of_host
        self._open, self._shut = True, False

    def _check(self) -> None:
        if not self._open:
            raise OSError(9, "Bad file descriptor")
        if self._connection.reset:
            raise ConnectionResetError(104, "Connection reset by peer")

    def sendall(self, data: bytes) -> None:
        self._check()
        if self._goes.ended:
            raise BrokenPipeError(32, "Broken pipe")
        if not self._of_host:
            self._goes.bytes += data
            return
        cut = self._connection.network.cut(data)
        self._goes.bytes += cut
        if cut != data:
            self._goes.ended = self._comes.ended = True
        self._connection.sent(data)

    def receive(self, most: int, seconds: float = math.inf) -> bytes:
        world, come, carries = self._connection.network.world, self._comes, self._arrives
        if not world.park(world.monotonic() + seconds, carries):
            raise TimeoutError("timed out")
        self._check()
        if self._shut:
            return b""
        data = bytes(come.bytes[:most])
        del come.bytes[:most]
        return data

    def _arrives(self) -> bool:
        """Tell whether there is something to read, if only that nothing more will be."""
        if not self._open or self._shut or self._connection.reset:
            return True
        return self._connection.network.carries and bool(self._comes.bytes or self._comes.ended)

    def shut(self) -> None:
        self._check()
        self._goes.ended = self._shut = True

    def close(self) -> None:
        self._goes.ended, self._open = True, False


class Door:
    """Where a robot listens; see `simulators.common.tcp.Listener`."""

    def __init__(self, network: Network) -> None:
        self._network = network
        network.listens = True

    def accept(self) -> tuple[End, str, str]:
        network = self._network
        network.world.park(math.inf, lambda: network.waiting or not network.listens)
        if not network.listens:
            raise OSError(9, "Bad file descriptor")
        made = network.waiting.popleft()
        return made.robot, "127.0.0.1", f"127.0.0.1:{40000 + made.number}"

    def close(self) -> None:
        self._network.listens = False
