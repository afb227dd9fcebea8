"""The iRat's driver: goals of people, exploring and charging, by the map of a brain in a process of its own."""

import contextlib
from collections.abc import Callable
from pathlib import Path

from robots.kit.contract.errors import ControlsReleased, GaveUp, HardwareFault, RobotError
from robots.kit.contract.session import JSON, OnStage, Outcome, Permit, RobotState, Session, Trace
from robots.kit.contract.values import check, number
from robots.kit.description import load
from robots.kit.drivers.irat.brain.messages import Care, Clear, Key, Packet
from robots.kit.drivers.irat.brain.process import SILENT, BrainProcess
from robots.kit.drivers.irat.charging import Charging
from robots.kit.drivers.irat.line import IratLine
from robots.kit.drivers.irat.protocol import Status, Velocity
from robots.kit.drivers.irat.roaming import Roaming
from robots.kit.drivers.irat.senses import Senses
from robots.kit.drivers.irat.spec import Mode
from robots.kit.drivers.irat.wheels import FLAT, REST, STEP_S, Wheels
from robots.kit.drivers.rosbridge_client import connected

NEVER_BEGAN = "The robot did not move: what it was told came too late over its line."
HEARD_S = 3.0  # within which the robot's topics arrive
BRAIN_S = 25.0  # within which the brain's process answers; its loops may have to be compiled


class Driver(Session):
    """A `robots.kit.contract.session.Session`. `settings` may hold `epoch`, and `folder`, where the map is kept."""

    opened = staticmethod(connected)  # how a connection is opened
    think = staticmethod(BrainProcess)  # makes the owner's end of the brain

    def __init__(self, address: str, settings: JSON, trace: Trace | None = None) -> None:
        super().__init__(address, settings, trace)
        folder = settings.get("folder") or Path(address).parent
        self._hand = load("irat")["hand"]
        wire, epoch = address.removeprefix("socket://"), int(settings.get("epoch") or 1)
        self.line = IratLine(wire, epoch, clock=self.clock, opened=self.opened)
        self.brain = self.think(Path(folder) / "brain", self._told, self.clock)
        self.senses = Senses(self.line, self.brain, self.keep, self.clock)
        self.wheels = Wheels(self.line, self.brain, self.senses, self.clock)
        self._roaming, self._charging = Roaming(self.wheels), Charging(self.wheels)

    def _told(self, packet: Packet) -> None:
        """Hand on a packet of the brain's streams."""
        if self.stream(packet.stream, packet.data, packet.key) and self.on_packet is not None:
            self.brain.post(Key(packet.stream))

    def connect(self) -> RobotState:
        """Open the line, listen, and start the brain; the robot is ready once that has answered.

        Raises HardwareFault; also where the battery is almost flat.
        """
        since = self.clock.monotonic()  # earlier messages over this connection do not count any more
        self.line.open()
        for newest in (self.line.status, self.line.odometry, self.line.battery, self.line.charger, self.line.ranges):
            newest.wait(HEARD_S, since)
        if self.senses.critical:
            raise HardwareFault(FLAT)
        self.brain.start()
        self.senses.start()
        self.brain.wait(self.clock.monotonic() - BRAIN_S, BRAIN_S)
        return self.state()

    def state(self) -> RobotState:
        """Ask the robot."""
        self.line.status.take(self.line.ask().encode())
        return self.keep(self.senses.state())

    def execute(self, kind: str, args: JSON, permit: Permit, on_stage: OnStage) -> Outcome:
        """Run one command to its end."""
        check("irat", kind, args, self.settings)
        motions: dict[str, Callable[[], JSON]] = {
            "goal": lambda: self._roaming.goal(args, permit, on_stage),
            "explore": lambda: self._roaming.explore(permit, on_stage),
            "charge": lambda: self._charge(permit, on_stage),
            "drive": lambda: self._drive(args, permit, on_stage),
        }
        if kind in motions:
            sent = motions[kind]()
            with contextlib.suppress(RobotError):  # it was done; whether the robot answers now is another matter
                return Outcome(sent, self.state())
            return Outcome(sent, self.latest())
        permit()
        on_stage("sent")
        pruning = kind == "pruning" and number(args, "on") >= 0.5
        self.brain.call((lambda n: Care(n, pruning)) if kind == "pruning" else Clear)
        on_stage("acknowledged")
        return Outcome(dict(args), self.latest())

    def _charge(self, permit: Permit, on_stage: OnStage) -> JSON:
        sent = self._charging.charge(permit, on_stage)
        self._roaming.charged()
        return sent

    def _drive(self, args: JSON, permit: Permit, on_stage: OnStage) -> JSON:
        """Drive by hand while `permit` allows it.

        Raises GaveUp if the robot never began: it refuses velocities that come late.
        """
        before, said = self.line.status.value, False
        wanted = Velocity(
            number(args, "forward") * float(self._hand["speed"]), number(args, "turn") * float(self._hand["turn"])
        )

        def act(free: Permit) -> None:
            nonlocal said
            while True:
                self.senses.awake()
                self.wheels.drive(wanted if self.wheels.hears() else REST, free)
                if not said:
                    said = True
                    on_stage("sent")
                    on_stage("acknowledged")
                self.clock.sleep(STEP_S)

        try:
            self.wheels.during(permit, Mode.HAND, act)
        except ControlsReleased:
            if said and wanted != REST and not self._moved_since(before):
                raise GaveUp(NEVER_BEGAN) from None
            raise
        return dict(args)

    def _moved_since(self, before: Status | None) -> bool:
        """Return whether a motion has begun; the robot is asked only if its newest status does not say so."""
        newest = self.line.status.value
        if before is None or newest is None:
            return True
        known = before.boot, before.motion
        asked = self.line.ask() if (newest.boot, newest.motion) == known else newest
        return (asked.boot, asked.motion) != known

    def picture(self, view: str, seconds: float) -> bytes | None:
        """Return the first picture of the robot's camera that arrives from now on."""
        return self.senses.picture(seconds)

    def hold(self) -> RobotState:
        """Hold at once; return when the robot says that it rests."""
        self.wheels.hold()
        return self.state()

    def recover(self, permit: Permit) -> RobotState:
        """Connect again after a fault; a brain that runs goes on."""
        permit()
        self.senses.close()
        self.line.close()
        state = self.connect()
        if not state.ready:
            raise HardwareFault(SILENT)
        return state

    def close(self) -> None:
        """End the brain and the connection; the robot holds."""
        self.senses.close()
        self.brain.close()
        self.line.close()
