"""The owner of one robot: creates its parts and connects them. Only the bootstep imports this file.

Threads: `control` runs motions and keeps the robot in order; `config` runs commands beside a motion; `watch` holds
motions that are no longer allowed, and `heartbeat` tells the supervisor that it does; `listen` receives stops; `link`,
`follow` and `renew` query the stores; `hold` holds what a row says is stopped; `state` and `camera` publish; `sound`
does while somebody listens.
"""

import logging
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

from django.conf import settings

from robots import bus
from robots.grants import goes_on_for, newest_grant
from robots.kit.brownout import Brownout
from robots.kit.clock import SYSTEM, Clock
from robots.kit.packets import Notice
from robots.models import Robot
from workers.authority.gate import Authority, Gate
from workers.authority.lane import CONFIG, MOTION, Lane, Pace
from workers.authority.lease import DatabaseClock, OwnerLease
from workers.authority.memory import KnownGrants, Link, StopLatch
from workers.commands.findings import Findings
from workers.commands.packages import Packages
from workers.commands.rows import abandon
from workers.commands.run import Commands, Runner
from workers.guard.deadman import DeadManTimer
from workers.guard.follow import Follower
from workers.guard.listen import Listener
from workers.guard.stop import Stop
from workers.guard.watch import Heartbeat, Watch
from workers.media.pictures import Pictures
from workers.media.sound import Sound
from workers.media.streams import Streams
from workers.media.trace import WireTrace
from workers.process.control import Control
from workers.process.regain import Listen, Regain
from workers.process.threads import Threads
from workers.robot.connection import Connection
from workers.robot.handover import Handover
from workers.robot.live import send_live
from workers.robot.machine import Machine
from workers.robot.owned import OwnedRobot
from workers.robot.recovery import Recovery
from workers.robot.settings import SettingsReset
from workers.robot.state_publisher import StatePublisher

log = logging.getLogger(__name__)
LOST = 3  # exit status: the robot was held, and its lease is lost
INTERRUPTED = "The robot's worker was interrupted and is back. Look at the picture, then go on."


def end_at_once() -> None:
    """End this process, whatever its threads do, after a moment in which its last words are written."""
    try:
        logging.shutdown()
    finally:
        os._exit(LOST)


class Owner:
    """All parts of one owner process, from taking the lease to its end."""

    def __init__(
        self, slug: str, clock: Clock = SYSTEM, on_lost: Callable[[], None] | None = None,
        listen: Listen = lambda queue, on: None, machine: Machine | None = None,
    ) -> None:  # fmt: skip
        robot = Robot.objects.get(slug=slug)
        run = Path(settings.VAR) / "run"
        run.mkdir(parents=True, exist_ok=True)
        machine = machine or Machine()
        self.clock, self.pace, self._brownout = clock, Pace(clock), Brownout()
        self.latch = StopLatch(run / f"{slug}.stopped")
        self.lease = OwnerLease(robot, run / f"{slug}.lock", clock, machine.processes)
        self.link = Link(clock, float(settings.FARHAND["REDIS_GONE_S"]))
        self.grants = KnownGrants(clock, self.lease.measured_now)
        stamps = DatabaseClock(clock, self.lease.now)  # of all that is published
        trace = WireTrace(slug, stamps)
        self.streams = Streams(slug, robot.spec().streams, stamps)
        self.owned = OwnedRobot(robot, self.lease, clock, trace.publish, self.streams, machine.session)
        self.authority = Authority(clock, self.lease, self.latch, self.link, self.grants)
        self.lane, self.beside = self._lane(MOTION), self._lane(CONFIG)
        self.deadman = DeadManTimer(clock)
        self.owned.time_left, self.owned.steered = lambda: self.lane.gate.time_left, lambda: self.deadman.steered
        self.pictures = Pictures(robot, stamps, self.owned.picture, machine.camera)
        self.owned.look = self.pictures.look
        self.heartbeat = Heartbeat(self.owned, run / f"{slug}.heartbeat")
        self._wire_safety(on_lost or end_at_once)
        self.threads = Threads(self.owned, self.watch.leave)
        sound = Sound(slug, stamps)
        recovery = Recovery(self.owned, self.lane.gate, self.pictures)
        self.connection = Connection(self.owned, self.lane, recovery)
        self.states = StatePublisher(self.owned, self.connection, self.latch, trace, self.pace, self.streams, sound)
        self.regain = Regain(self.owned, self.lane, self.beside, self.connection, self.watch, listen)
        self._wire_commands()

    def _lane(self, name: str) -> Lane:
        gate = Gate(self.authority, self.owned.known_state)
        return Lane(name, gate, self.clock, self.pace)

    def _wire_safety(self, on_lost: Callable[[], None]) -> None:
        owned, lanes = self.owned, self.lanes
        self.stopping = Stop(owned, self.latch)
        self.watch = Watch(owned, lanes, self.deadman, self._brownout, self.heartbeat, on_lost)
        self.follower = Follower(owned, self.authority, lanes, self.stopping, self.pace)
        self.listener = Listener(owned, self.stopping, self.grants, lanes, self.deadman)

    def _wire_commands(self) -> None:
        owned, pictures, connection = self.owned, self.pictures, self.connection
        note = self.stopping.note
        findings = self.findings = Findings(owned, pictures, Path(settings.VAR) / "findings" / owned.robot.slug)
        self.packages = packages = Packages(Path(settings.VAR) / "packages" / owned.robot.slug)
        beside, deadman = self.beside, self.deadman
        self.runner = Runner(owned, self.lane, deadman, pictures, findings, packages, connection.faulted, note)
        runner_beside = Runner(owned, beside, deadman, pictures, findings, packages, connection.config_faulted, note)
        self.config = Commands(owned, beside, runner_beside.run, pictures)
        settings_reset = SettingsReset(owned, connection, beside, self.config.run_due)
        self.motion = Commands(owned, self.lane, self.runner.run, pictures, settings_reset.settle)
        handover = Handover(owned, self.lane.gate, pictures, connection, settings_reset)
        self.control = Control(owned, self.motion, self.config, connection, self.regain, handover, pictures, findings)

    @property
    def lanes(self) -> tuple[Lane, ...]:
        """Return the lanes that have a thread; `config` has one only if the robot declares such commands."""
        beside = any(kind.lane == CONFIG for kind in self.owned.robot.spec().commands)
        return (self.lane, self.beside) if beside else (self.lane,)

    def own(self, give_up: Callable[[], bool]) -> bool:
        """Wait for the lease; opens nothing. Return False if `give_up` said so."""
        owned = self.lease.acquire(give_up)
        self.owned.renew_driver()
        return owned

    def start(self) -> None:
        """Connect to the hardware, end interrupted commands, then start the threads."""
        owned, robot, begin = self.owned, self.owned.robot, self.threads.begin
        owned.running = True
        self.link.note_answer()
        self.grants.know_newest(newest_grant(robot))
        begin("renew", self._renew)  # a line that opens slowly must not cost the lease
        self.stopping.begin()
        self._end_interrupted()
        begin("watch", self.watch.loop)
        begin("heartbeat", self.heartbeat.loop)
        begin("listen", self.listener.loop)
        begin("link", self.follower.ask_link)
        begin("follow", self.follower.rows)
        begin("hold", self.follower.hold)
        begin("control", self.control.loop)
        if self.beside in self.lanes:
            begin("config", partial(self.config.loop_config, lambda: self.connection.connected))
        begin("state", self.states.loop)
        for camera in self.pictures.cameras:
            begin(f"camera {camera.name}", partial(send_live, owned, self.pictures, self._brownout, camera.index))

    def _end_interrupted(self) -> None:
        """Connect, and end what an earlier owner has begun.

        A robot that may go on by itself counts as moving until it has been asked: what it was doing ends after that,
        or, where it cannot be reached, once it rests by itself.
        """
        owned, robot = self.owned, self.owned.robot
        alone_s = goes_on_for(robot, robot.settings)
        self.control.moves_until = owned.clock.monotonic() + alone_s if alone_s is not None else 0.0
        interrupted = [] if alone_s is not None else abandon(robot, owned.now(), self.packages)
        self.connection.begin()
        if alone_s is not None and self.connection.connected:
            interrupted = abandon(robot, owned.now(), self.packages)
        if interrupted:
            bus.publish(robot.slug, Notice(INTERRUPTED, "warning"))

    def _renew(self) -> None:
        self.lease.keep(lambda: self.owned.running)

    def stop(self) -> None:
        """Hold the robot, then release everything."""
        owned = self.owned
        if not owned.running:
            self.lease.give_back()
            return
        owned.running = False
        self.wake()
        try:
            state = owned.driver.latest()
            busy = any(lane.current is not None for lane in self.lanes)
            if self.connection.connected and (state is None or state.moving or busy):
                owned.driver.hold()
        except Exception:
            log.exception("the robot could not be held")
        for name in ("control", "config"):
            self.threads.join(name, 8.0)
        self.listener.close()
        self.pictures.close()
        owned.driver.close()
        self.lease.give_back()

    def wake(self) -> None:
        """Wake all lanes: command rows may wait."""
        for lane in self.lanes:
            lane.wake()
