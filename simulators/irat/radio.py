"""The robot's rosbridge without its network, which is in `server`: its clients and the messages to each."""

from collections.abc import Callable, Iterable

from robots.kit.clock import TIMER, WALL, Timer, Wall
from robots.kit.drivers.rosbridge import Message, encode
from simulators.common.faults import FaultBoard
from simulators.common.journal import Note
from simulators.irat.operations import Operations, Robot
from simulators.irat.peer import Peer

MOST_PEERS = 32  # one more replaces the oldest client that does not command
Messages = Iterable[tuple[str, Callable[[int], Message]]]  # topics, and what makes their message from its number


class Radio:
    """The robot's clients. Not for several threads, except for its properties."""

    def __init__(self, robot: Robot, faults: FaultBoard, note: Note, clock: Timer = TIMER, wall: Wall = WALL) -> None:
        self._faults, self._note, self._clock, self._sequence = faults, note, clock, 0
        self.peers: list[Peer] = []
        self._operations = Operations(robot, note, clock, wall)
        self.watched: frozenset[str] = frozenset()  # topics that somebody subscribes to
        self.off = False  # without power: nobody is answered

    @property
    def epoch(self) -> int:
        """Return the commander's epoch, 0 if there is none."""
        return self._operations.claims.epoch

    @property
    def silent(self) -> bool:
        """Return whether no message reaches the robot."""
        return self.off or bool(self._faults.value("awol"))

    @property
    def holds(self) -> bool:
        """Return whether somebody waits for the answer to a hold."""
        return bool(self._operations.holds)

    def join(self, peer: Peer) -> None:
        """Accept a client; if there are too many, disconnect the oldest one that does not command."""
        self.peers.append(peer)
        if len(self.peers) > MOST_PEERS:
            oldest = next(p for p in self.peers if p is not self._operations.claims.commander)
            self.peers.remove(oldest)
            oldest.cut()

    def leave(self, peer: Peer) -> None:
        """Forget a client whose connection has ended; the robot holds if it commanded."""
        if peer in self.peers:
            self.peers.remove(peer)
        self._look()
        self._operations.leave(peer)

    def take(self, peer: Peer, data: str | bytes) -> None:
        """Execute what a frame asks for, unless no message reaches the robot. The next frame is read in any case."""
        if self.silent:
            return
        try:
            self._operations.take(peer, data)
        except Exception as error:  # noqa: BLE001 - one frame must not end the others' service
            self._note("crash", error=f"{type(error).__name__}: {error}")
            peer.answer(encode(op="status", level="error", msg="the robot failed at this frame"))
        self._look()

    def _look(self) -> None:
        self.watched = frozenset(topic for peer in self.peers for topic in peer.subscriptions)

    def publish(self, messages: Messages) -> None:
        """Send messages of topics to the clients for which they are due; each is made once, with its number."""
        now, self._sequence = self._clock.monotonic(), self._sequence + 1
        for topic, make in messages:
            wanting = [peer for peer in self.peers if peer.wants(topic, now)]
            if wanting:
                frame = encode(op="publish", topic=topic, msg=make(self._sequence))
                for peer in wanting:
                    peer.show(topic, frame)

    def settle(self) -> None:
        """Answer holds; called after each tick of the robot."""
        self._operations.settle()

    def power_off(self) -> None:
        """End all connections at once, and forget the commander."""
        self._operations.claims.forget()
        for peer in list(self.peers):
            peer.cut()

    def close(self) -> None:
        """End all connections."""
        self.power_off()
