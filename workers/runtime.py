"""The owner of one robot: driver, camera, lease, stop and the loops beside the task pool.

Threads: `control` claims and executes; `sentinel` watches stop, grant and link and holds; `stop` listens on the bus;
`renew` keeps the lease; `state` and `camera` publish. Every thread keeps to its own database connection.
"""

import contextlib
import logging
import os
import threading
import time
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

import redis
from django.conf import settings
from django.db import DatabaseError, InterfaceError, close_old_connections

from robots import bus
from robots.clock import SYSTEM, Clock
from robots.drivers.contract import Driver, RobotState, make_driver
from robots.drivers.errors import HardwareFault, RobotError
from robots.messages import Changed, Notice
from robots.models import Command, Grant, Lease, Robot
from robots.states import Cycle
from workers import ledger
from workers.broadcast import Broadcast
from workers.executor import Executor
from workers.handover import hand_over
from workers.latch import StopLatch
from workers.lease import OwnerLease
from workers.permit import Gate
from workers.pictures import Pictures

log = logging.getLogger(__name__)
SWEEP_S = 0.1
LOST = 3  # exit status that says: the lease is gone


class Runtime:
    """Everything that one owner process holds."""

    def __init__(self, slug: str, clock: Clock = SYSTEM, on_lost: Callable[[], None] | None = None) -> None:
        self.clock = clock
        self.robot = Robot.objects.get(slug=slug)
        run = Path(settings.VAR) / "run"
        run.mkdir(parents=True, exist_ok=True)
        self._heartbeat = run / f"{slug}.heartbeat"
        self.latch = StopLatch(run / f"{slug}.stopped")
        self.lease = OwnerLease(self.robot, run / f"{slug}.lock", clock)
        self.gate = Gate(self.lease, self.latch, clock, float(settings.FARHAND["REDIS_GONE_S"]))
        self.broadcast = Broadcast(self)
        self.driver: Driver = self._make_driver()
        self.pictures = Pictures(self.robot, clock)
        self.executor = Executor(self)
        self._wake = threading.Event()
        self.running = False
        self._busy_until = 0.0
        self._beat = clock.monotonic()
        self._current: Command | None = None
        self.connected = False
        self._retry_at = 0.0
        self._threads: list[threading.Thread] = []
        self._on_lost = on_lost or (lambda: os._exit(LOST))
        self._pubsub: Any = None

    def _make_driver(self) -> Driver:
        return make_driver(
            self.robot.driver, self.robot.wire_address, self.robot.driver_settings(), self.broadcast.trace
        )

    def now(self) -> datetime:
        """Return the database's time."""
        return self.lease.now()

    def own(self, give_up: Callable[[], bool]) -> bool:
        """Wait for the lease; nothing is opened before."""
        return self.lease.acquire(give_up)

    def start(self) -> None:
        """Ask the hardware, end what was interrupted, then begin to serve."""
        self.running = True
        self.gate.link_seen = self.clock.monotonic()
        self._begin("renew", self._renew)  # a line that is slow to open must not cost the lease
        interrupted = ledger.abandon(self.robot, self.now())
        self._connect()
        if interrupted:
            bus.publish(
                self.robot.slug,
                Notice("The robot's worker was interrupted and is back. Look at the picture, then go on.", "warning"),
            )
        loops = {
            "sentinel": self._sentinel, "stop": self._listen,
            "control": self._control, "state": self.broadcast.states, "camera": self.broadcast.pictures,
        }  # fmt: skip
        for name, loop in loops.items():
            self._begin(name, loop)

    def _begin(self, name: str, loop: Callable[[], None]) -> None:
        thread = threading.Thread(target=self._guarded, args=(name, loop), name=name, daemon=True)
        thread.start()
        self._threads.append(thread)

    def stop(self) -> None:
        """Hold the robot, then let go of everything."""
        if not self.running:
            self.lease.give_back()
            return
        self.running = False
        self._wake.set()
        with contextlib.suppress(RobotError):
            state = self.driver.latest()
            if self.connected and (state is None or state.moving or self._current is not None):
                self.driver.hold()
        for thread in self._threads:
            if thread.name == "control":
                thread.join(8.0)
        with contextlib.suppress(Exception):  # there may be none
            self._pubsub.close()
        self.driver.close()
        self.lease.give_back()

    def look(self) -> None:
        """Answer the bell."""
        self._wake.set()

    def _guarded(self, name: str, loop: Callable[[], None]) -> None:
        """Run a loop for as long as we live; a store that is down is waited for."""
        while self.running:
            try:
                loop()
            except (DatabaseError, InterfaceError) as error:
                log.warning("%s: the database does not answer: %s", name, error)
                close_old_connections()
                time.sleep(0.5)
            except Exception:
                log.exception("%s failed and goes on", name)
                time.sleep(0.5)

    def _reach(self) -> RobotState:
        """Open the wire and ask; what moves is held."""
        state = self.driver.connect()
        return self.driver.hold() if state.moving else state

    def _connect(self) -> None:
        try:
            state = self._reach()
            self.connected = True
        except RobotError as error:
            self.connected = False
            self._unready(str(error), incident=error.code)
            self._retry_at = self.clock.monotonic() + 2.0
            self.driver.close()
            return
        self.remember(state)
        cycle = Robot.objects.values_list("cycle", flat=True).get(pk=self.robot.pk)
        if cycle in (Cycle.OFFLINE, Cycle.FAULT, Cycle.READY, Cycle.OFFERED):
            self.set_cycle(Cycle.HANDOVER, "", cycle)  # what was not verified is not offered
        elif cycle == Cycle.OPERATING and not state.ready:
            self.faulted(HardwareFault("The controller lost its calibration."), None)
        elif not self.latch.latched:
            with contextlib.suppress(RobotError):
                self.executor.look(state, None)

    def _unready(self, text: str, incident: str = "") -> None:
        if self.robot.reason != text and incident:
            ledger.incident(self.robot, incident, text, self.now(), remedy="Trying again every few seconds.")
        self.robot.reason = text[:300]
        Robot.objects.filter(pk=self.robot.pk).exclude(
            cycle__in=(Cycle.LOCKED_OUT, Cycle.OPERATING, Cycle.OFFERED)
        ).update(cycle=Cycle.FAULT, reason=text[:300])
        Robot.objects.filter(pk=self.robot.pk).update(reason=text[:300])
        bus.publish(self.robot.slug, Changed("robot"))

    def faulted(self, error: HardwareFault, command: Command | None) -> None:
        """Soft reset after a hardware fault; what cannot be mended is a fault to wait out."""
        if self.executor.soft_reset(error, command):
            self.connected = True
            Robot.objects.filter(pk=self.robot.pk).update(reason="")
            self.robot.reason = ""
            bus.publish(self.robot.slug, Changed("robot"))
            return
        self.connected = False
        self._unready(str(error))
        self._retry_at = self.clock.monotonic() + 3.0

    def _mend(self) -> None:
        """Try again to reach the robot and put it in order."""
        if self.clock.monotonic() < self._retry_at:
            return
        self._retry_at = self.clock.monotonic() + 3.0
        self.driver.close()
        try:
            state = self._reach()
            grant = Grant.objects.filter(robot=self.robot, ended_at=None).first()
            if not state.ready and grant is not None:
                self.gate.open_for(grant, self.now())
                state = self.driver.recover(self.gate.check)
        except RobotError as error:
            self.driver.close()
            self._unready(str(error))
            return
        self.connected = True
        self.remember(state)
        Robot.objects.filter(pk=self.robot.pk).update(reason="")
        self.robot.reason = ""
        self.set_cycle(Cycle.HANDOVER, "", Cycle.FAULT)
        bus.publish(self.robot.slug, Notice("The robot answers again. Look at the picture, then go on.", "info"))
        bus.publish(self.robot.slug, Changed("robot"))
        with contextlib.suppress(RobotError):
            self.executor.look(state, None)

    def lost_while_idle(self, error: HardwareFault) -> None:
        """Note that the hardware stopped answering while no command ran; the control loop mends it."""
        busy = self._current is not None or self._busy_until > self.clock.monotonic()
        if self.running and not busy:
            log.warning("the robot: %s", error)
            self.connected, self._retry_at = False, 0.0
            self._unready(str(error), incident=error.code)

    def later(self, seconds: float) -> None:
        """Look after the robot again in `seconds` (s)."""
        self.connected = False
        self._retry_at = self.clock.monotonic() + seconds

    def set_cycle(self, cycle: Cycle, reason: str, was: str) -> bool:
        """Advance the robot's turn cycle by a conditional update."""
        done = Robot.objects.filter(pk=self.robot.pk, cycle=was).update(cycle=cycle, reason=reason[:300])
        if done:
            bus.publish(self.robot.slug, Changed("robot"))
        return bool(done)

    def keep_calibration(self, found: dict[str, Any]) -> None:
        """Store a measured calibration."""
        Robot.objects.filter(pk=self.robot.pk).update(calibration=found, calibrated_at=self.now())
        self.robot.refresh_from_db()
        self.pictures.configure(self.robot)

    def remember(self, state: RobotState) -> None:
        """Keep the state where pages and the server's checks read it."""
        Lease.objects.filter(robot=self.robot, epoch=self.lease.epoch).update(
            state={
                "joints": list(state.joints),
                "pose": list(state.pose),
                "moving": state.moving,
                "ready": state.ready,
            },
            state_at=self.now(),
        )

    def _renew(self) -> None:
        while self.running:
            try:
                self.lease.renew()
            except (DatabaseError, InterfaceError):
                close_old_connections()
            if not self.lease.valid:
                self._lose_lease()
            time.sleep(1.0)

    def _lose_lease(self) -> None:
        log.error("the lease of %s is lost: holding and leaving", self.robot.slug)
        self.running = False
        with contextlib.suppress(Exception):
            self.driver.hold()
        self.driver.close()
        self._on_lost()

    def _control(self) -> None:
        swept = 0.0
        while self.running:
            self._wake.wait(SWEEP_S)
            self._wake.clear()
            self._beat = self.clock.monotonic()
            if self.connected:
                self._run_due()  # answer the bell before anything else
                if self._beat - swept < SWEEP_S:
                    continue
            swept = self._beat
            self._refresh()
            ledger.expire(self.robot, self.lease.epoch, self.now())
            if not self.connected:
                self._busy_until = self.clock.monotonic() + 30.0
                self._mend()
                self._busy_until = 0.0
            self._run_due()
            if self.connected and self.robot.cycle == Cycle.HANDOVER:
                self._busy_until = self.clock.monotonic() + 180.0
                hand_over(self)
                self._busy_until = 0.0

    def _run_due(self) -> None:
        for command in ledger.due(self.robot, self.lease.epoch).select_related("grant"):
            if not self.running:
                return
            self._one(command)

    def _one(self, command: Command) -> None:
        command.robot = self.robot
        if not ledger.claim(command, self.lease.epoch, self.now()):
            return
        self._current = command
        self._busy_until = self.clock.monotonic() + command.limit_s + 10.0
        try:
            self.executor.run(command)
        finally:
            self._current, self._busy_until = None, 0.0

    def _refresh(self) -> None:
        """Follow changes of the robot's row: settings, cycle, address."""
        fresh = Robot.objects.get(pk=self.robot.pk)
        changed = (fresh.address, fresh.speed) != (self.robot.address, self.robot.speed)
        self.robot = fresh
        self.pictures.configure(fresh)
        if changed:
            self.driver.close()
            self.driver = self._make_driver()
            self.connected, self._retry_at = False, 0.0

    def _sentinel(self) -> None:
        while self.running:
            now = self.clock.monotonic()
            if bus.alive():
                self.gate.link_seen = self.clock.monotonic()
            self._follow_stop()
            self._follow_grant()
            state = self.driver.latest()
            if state is not None and state.moving and (self.gate.link_down or self.gate.grant_over):
                with contextlib.suppress(RobotError):
                    self.driver.hold()
            if now - self._beat < 2.0 or now < self._busy_until:
                self._touch_heartbeat()
            time.sleep(SWEEP_S)

    def _touch_heartbeat(self) -> None:
        with contextlib.suppress(OSError):
            self._heartbeat.touch()

    def _follow_stop(self) -> None:
        latched = Robot.objects.values_list("stop_latched", flat=True).get(pk=self.robot.pk)
        if latched and not self.latch.latched:
            self.halt("row")
        elif self.latch.latched and self.latch.row_pending:
            Robot.objects.filter(pk=self.robot.pk).update(stop_latched=True)
            self.latch.row_pending = False
            bus.publish(self.robot.slug, Changed("stop"))
        elif self.latch.latched and not latched:
            self.latch.release()
            bus.publish(self.robot.slug, Changed("stop"))

    def _follow_grant(self) -> None:
        if self.gate.grant_id and self.gate.grant_id not in self.gate.revoked:
            grant = Grant.objects.filter(pk=self.gate.grant_id).first()
            if grant is None or grant.ended_at is not None:
                self.gate.revoke(self.gate.grant_id)
            else:
                self.gate.open_for(grant, self.now())  # a turn may have been lengthened
        overdue = Grant.objects.filter(robot=self.robot, ended_at=None, until__lte=self.now()).first()
        if overdue is not None:
            Grant.objects.filter(pk=overdue.pk, ended_at=None).update(ended_at=self.now(), end_reason="time is up")
            self.gate.revoke(overdue.pk)
            bus.publish(self.robot.slug, Changed("queue"))

    def halt(self, source: str) -> None:
        """Stop: hold the hardware, latch on disk; the row follows."""
        first = not self.latch.latched
        self.latch.forbid()
        try:
            self.driver.hold()
        except RobotError as error:
            log.error("a stop could not be confirmed: %s", error)
            with contextlib.suppress(DatabaseError, InterfaceError):
                ledger.incident(self.robot, "stop_failed", f"A stop could not be confirmed: {error}", self.now())
        self.latch.latch()
        with contextlib.suppress(DatabaseError, InterfaceError):  # else the sentinel writes it
            Robot.objects.filter(pk=self.robot.pk).update(stop_latched=True)
            self.latch.row_pending = False
        if first:
            log.info("stopped by %s", source)
            bus.publish(self.robot.slug, Changed("stop"))

    def _listen(self) -> None:
        """Hear stops, and the quick bell, on channels of their own."""
        try:
            connection = bus.listener()
            self._pubsub = connection.pubsub(ignore_subscribe_messages=True)
            bell = bus.bell_channel(self.robot.slug)
            self._pubsub.subscribe(bus.stop_channel(self.robot.slug), bell)
            while self.running:
                message = self._pubsub.get_message(timeout=1.0)
                if message and message["channel"] == bell.encode():
                    self.look()
                elif message:
                    self.halt("bus")
        except (redis.RedisError, OSError, ValueError):
            time.sleep(0.2)
