"""Operations that frames ask for: subscriptions, velocities, services."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from robots.kit.clock import TIMER, WALL, Limit, Timer, Wall
from robots.kit.drivers.irat.protocol import (
    CLAIM,
    COMMAND,
    DRIVE,
    EVERY_S,
    HOLD,
    LATE_S,
    REST_S,
    STATUS,
    TOPICS,
    Drive,
    Status,
    Velocity,
    epoch_of,
)
from robots.kit.drivers.rosbridge import Malformed, Operation, encode, operation, received
from simulators.common.journal import Note
from simulators.common.rovers.motor_board import End
from simulators.irat.claims import Claims
from simulators.irat.peer import Peer, Subscription

EARLY = 0.8  # share of a topic's period after which its next message is not too early
MOST_SUBSCRIPTIONS = 64
MOST_HOLDS = 32  # of one client, not answered yet


class Refused(Malformed):
    """A valid request that is refused now; the text says why."""


class Robot(Protocol):
    """The robot behind the network; its methods may be called from any thread."""

    @property
    def moving(self) -> bool:
        """Return whether a motion runs."""

    @property
    def motion(self) -> int:
        """Return the number of the newest motion."""

    def velocity(self, velocity: Velocity, epoch: int) -> str:
        """Drive; return why that is refused, in one sentence; an empty text if it is not."""

    def hold(self, why: End = End.HELD) -> None:
        """Brake to rest."""

    def report(self) -> Status:
        """Return the state that the robot reports."""


@dataclass
class _Hold:
    """A hold that is not answered yet, and the motion that it ends."""

    peer: Peer
    operation: Operation
    motion: int
    limit: Limit


class Operations:
    """Executes what frames ask for; not for several threads. `settle` answers the holds once the robot rests."""

    def __init__(self, robot: Robot, note: Note, clock: Timer = TIMER, wall: Wall = WALL) -> None:
        self._robot, self._note, self._clock, self._wall = robot, note, clock, wall
        self.claims = Claims(clock)
        self.holds: list[_Hold] = []
        self._held_at = 0.0  # by `wall`, the newest hold
        self._services: dict[str, Callable[[Peer, Operation], None]] = {
            HOLD: self._hold, CLAIM: self._claim, STATUS: self._report,
            "/rosapi/topics": self._list_topics, "/rosapi/services": self._list_services,
        }  # fmt: skip

    def take(self, peer: Peer, data: str | bytes) -> None:
        """Execute what one frame asks for, or answer why it is refused."""
        try:
            found = received(data)
        except Malformed as error:
            peer.answer(encode(op="status", level="error", msg=str(error)))
            return
        ident, called = found.get("id"), found.get("op") == "call_service"
        try:
            asked = operation(found)
            if asked.warning:
                peer.answer(encode(op="status", level="warning", msg=asked.warning, id=ident))
            getattr(self, f"_{asked.op}")(peer, asked)
        except Malformed as error:
            if called:
                said = encode(
                    op="service_response", id=ident, service=found.get("service"), values=str(error), result=False
                )
            else:
                said = encode(op="status", level="error", msg=str(error), id=ident)
            peer.answer(said)

    def leave(self, peer: Peer) -> None:
        """Hold the robot if its commander has gone."""
        if self.claims.leave(peer):
            self._robot.hold(End.LOST)
            self._note("disconnected", peer=peer.name)

    # operations, named as rosbridge names them

    def _advertise(self, peer: Peer, asked: Operation) -> None:
        self._topic(asked)
        if asked.name not in (COMMAND, DRIVE):
            raise Refused(f"{asked.name} is the robot's own; only {COMMAND} and {DRIVE} can be published here")

    def _unadvertise(self, peer: Peer, asked: Operation) -> None:
        self._topic(asked)

    def _publish(self, peer: Peer, asked: Operation) -> None:
        self._advertise(peer, asked)
        drive = Drive.decode(asked.body) if asked.name == DRIVE else None
        velocity = drive.velocity if drive else Velocity.decode(asked.body)
        if self.claims.commander is not peer:
            self._note("refused", peer=peer.name, why="no claim")
            raise Refused(f"claim the robot first: call {CLAIM} with your epoch")
        if drive:
            self._answers(drive, peer)
        if why := self._robot.velocity(velocity, peer.epoch):
            raise Refused(why)

    def _answers(self, drive: Drive, peer: Peer) -> None:
        """Refuse a velocity of another commander, and one that answers to odometry that is old or precedes a hold."""
        if drive.epoch != peer.epoch:
            raise Refused(f"epoch {drive.epoch} does not command; {peer.epoch} does")
        late = self._wall() - drive.stamp
        if abs(late) > LATE_S:
            self._note("late", seconds=round(late, 3))
            raise Refused(f"this velocity answers to odometry of another time, {late:.1f} s ago; answer to the newest")
        if 0 <= self._held_at - drive.stamp <= 2 * LATE_S:  # an older one is late, unless `wall` was set back
            self._note("late", seconds=round(late, 3))
            raise Refused("this velocity answers to odometry from before the hold; answer to the newest")

    def _subscribe(self, peer: Peer, asked: Operation) -> None:
        self._topic(asked)
        if sum(map(len, peer.subscriptions.values())) >= MOST_SUBSCRIPTIONS:
            raise Refused(f"a connection has at most {MOST_SUBSCRIPTIONS} subscriptions")
        if asked.name in (COMMAND, DRIVE):
            raise Refused(f"{asked.name} is heard by the robot only")
        wishes = peer.subscriptions.setdefault(asked.name, {})
        wishes[asked.id] = Subscription(max(asked.throttle_s, EARLY * EVERY_S[asked.name]))

    def _unsubscribe(self, peer: Peer, asked: Operation) -> None:
        wishes = peer.subscriptions.get(asked.name, {})
        wishes.pop(asked.id, None)
        if asked.id is None or not wishes:
            peer.subscriptions.pop(asked.name, None)

    def _status(self, peer: Peer, asked: Operation) -> None:
        """Ignore a client's message of status."""

    _set_level = _status

    def _topic(self, asked: Operation) -> None:
        if asked.name not in TOPICS:
            raise Refused(f"there is no topic {asked.name}; known: {', '.join(TOPICS)}")
        if asked.type and asked.type != TOPICS[asked.name]:
            raise Refused(f"{asked.name} has the type {TOPICS[asked.name]}, not {asked.type}")

    def _call_service(self, peer: Peer, asked: Operation) -> None:
        if asked.name not in self._services:
            raise Refused(f"there is no service {asked.name}; known: {', '.join(self._services)}")
        self._services[asked.name](peer, asked)

    # services

    def _answer(self, peer: Peer, asked: Operation, values: Any, result: bool = True) -> None:
        peer.answer(encode(op="service_response", id=asked.id, service=asked.name, values=values, result=result))

    def _claim(self, peer: Peer, asked: Operation) -> None:
        epoch = epoch_of(asked.named("epoch"))
        if why := self.claims.why_not(peer, epoch):
            self._note("refused", peer=peer.name, why=why)
            self._answer(peer, asked, {"success": False, "message": why, "epoch": self.claims.epoch})
            return
        if self._robot.moving and self.claims.epoch != epoch:
            self._robot.hold(End.REPLACED)
        other = self.claims.grant(peer, epoch)
        self._note("connected", peer=peer.name, epoch=epoch)
        if other is not None:
            why = f"epoch {epoch} commands now"
            other.answer(encode(op="status", level="warning", msg=why))
        self._answer(peer, asked, {"success": True, "message": "you command", "epoch": epoch})

    def _report(self, peer: Peer, asked: Operation) -> None:
        self._answer(peer, asked, self._robot.report().encode())

    def _list_topics(self, peer: Peer, asked: Operation) -> None:
        self._answer(peer, asked, {"topics": list(TOPICS), "types": list(TOPICS.values())})

    def _list_services(self, peer: Peer, asked: Operation) -> None:
        self._answer(peer, asked, {"services": list(self._services)})

    def _hold(self, peer: Peer, asked: Operation) -> None:
        """Hold at once; answer when the robot rests. Every client may stop the robot, with or without a claim."""
        self._held_at = self._wall()
        self._note("hold", peer=peer.name, moving=self._robot.moving)
        self._robot.hold()
        if sum(hold.peer is peer for hold in self.holds) >= MOST_HOLDS:
            raise Refused(f"{MOST_HOLDS} holds wait for their answers already; the robot is being held")
        self.holds.append(_Hold(peer, asked, self._robot.motion, Limit(self._clock, REST_S)))
        self.settle()

    def settle(self) -> None:
        """Answer the holds if the robot rests, and each hold that has waited too long; called after each tick."""
        for hold in list(self.holds):
            rests = not self._robot.moving or self._robot.motion != hold.motion  # it may have been driven on since
            if rests or hold.limit.over:
                self.holds.remove(hold)
                message = "at rest" if rests else f"the robot still moves {REST_S:g} s after the hold"
                self._answer(hold.peer, hold.operation, {"success": rests, "message": message})
