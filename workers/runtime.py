"""The owner of one robot: driver, camera, lease, stop and the loops beside the task pool.

Threads: `control` claims and executes; `watch` holds what may no longer move; `listen` hears
stops; `link`, `follow` and `renew` ask the stores; `state` and `camera` publish.
"""

import contextlib
import logging
import os
import threading
from collections.abc import Callable
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

from django.conf import settings
from django.db import Error, close_old_connections

from robots import bus
from robots.brownout import Brownout
from robots.clock import SYSTEM, Clock
from robots.drivers.contract import Driver, RobotState, make_driver
from robots.drivers.errors import RobotError
from robots.grants import newest_grant
from robots.messages import Changed, Notice
from robots.models import Command, Lease, Robot
from robots.states import Cycle
from workers import ledger
from workers.broadcast import Broadcast
from workers.executor import Executor
from workers.guard import Guard
from workers.hand import Hand
from workers.handover import hand_over
from workers.latch import StopLatch
from workers.lease import OwnerLease
from workers.permit import Gate
from workers.pictures import Pictures
from workers.reach import Reach
from workers.regain import Listen, regain

log = logging.getLogger(__name__)
SWEEP_S = 0.1
LOOK_AGAIN_S = 3.0
RENEW_S = 0.75  # three tries within a lease of three seconds
SILENT_S = 2.0
LOST = 3  # exit status that says: another owner has the robot


class Runtime:
    """Everything that one owner process holds."""

    def __init__(
        self, slug: str, clock: Clock = SYSTEM, on_lost: Callable[[], None] | None = None,
        listen: Listen = lambda queue, on: None,
    ) -> None:  # fmt: skip
        self.clock, self._listen = clock, listen
        self.brownout = Brownout()
        self.robot = Robot.objects.get(slug=slug)
        run = Path(settings.VAR) / "run"
        run.mkdir(parents=True, exist_ok=True)
        self.latch = StopLatch(run / f"{slug}.stopped")
        self.lease = OwnerLease(self.robot, run / f"{slug}.lock", clock)
        self.gate = Gate(self.lease, self.latch, clock, float(settings.FARHAND["REDIS_GONE_S"]))
        self.broadcast = Broadcast(self)
        self.driver: Driver = self._make_driver()
        self.pictures = Pictures(self.robot, clock)
        self.executor = Executor(self)
        self.hand = Hand(clock)
        self.reach = Reach(self)
        self.guard = Guard(self, run / f"{slug}.heartbeat", on_lost or (lambda: os._exit(LOST)))
        self._wake = threading.Event()
        self.running = False
        self.rung = 0  # how often the bell was heard
        self.beat = clock.monotonic()  # when the control loop came round last
        self.current: Command | None = None
        self._busy_until = self._looked = 0.0
        self._threads: list[threading.Thread] = []

    def renew_driver(self) -> None:
        """Make the driver anew, for the epoch that we own the robot with; some controllers want to be told it."""
        self.driver = self._make_driver()

    def _make_driver(self) -> Driver:
        return make_driver(
            self.robot.driver,
            self.robot.wire_address,
            self.robot.driver_settings(self.lease.epoch),
            self.broadcast.trace,
        )

    def now(self) -> datetime:
        """Return the database's time."""
        return self.lease.now()

    @property
    def busy(self) -> bool:
        """Tell whether the control loop is at something that takes its time."""
        return self.current is not None or self._busy_until > self.clock.monotonic()

    @property
    def sound(self) -> bool:
        """Tell whether the control loop comes round, or is away for no longer than it said."""
        now = self.clock.monotonic()
        return now - self.beat < SILENT_S or now < self._busy_until

    @contextlib.contextmanager
    def taking(self, seconds: float) -> Any:
        """Say that the control loop may be away for `seconds` (s)."""
        self._busy_until = self.clock.monotonic() + seconds
        try:
            yield
        finally:
            self._busy_until = 0.0

    def own(self, give_up: Callable[[], bool]) -> bool:
        """Wait for the lease; nothing is opened before."""
        owned = self.lease.acquire(give_up)
        self.renew_driver()
        return owned

    def start(self) -> None:
        """Ask the hardware, end what was interrupted, then begin to serve."""
        self.running = True
        self.gate.link_seen = self.clock.monotonic()
        self.gate.know_newest(newest_grant(self.robot))
        self._begin("renew", self._renew)  # a line that is slow to open must not cost the lease
        interrupted = ledger.abandon(self.robot, self.now())
        self.reach.connect()
        if interrupted:
            bus.publish(
                self.robot.slug,
                Notice("The robot's worker was interrupted and is back. Look at the picture, then go on.", "warning"),
            )
        loops = {
            "watch": self.guard.watch, "listen": self.guard.listen, "link": self.guard.link,
            "follow": self.guard.follow, "control": self._control,
            "state": self.broadcast.states,
        }  # fmt: skip
        for eye in self.pictures.eyes:
            loops[f"camera {eye.name}"] = partial(self.broadcast.pictures, eye.index)
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
            if self.reach.connected and (state is None or state.moving or self.current is not None):
                self.driver.hold()
        for thread in self._threads:
            if thread.name == "control":
                thread.join(8.0)
        if self.guard.pubsub is not None:
            with contextlib.suppress(OSError):
                self.guard.pubsub.close()
        self.driver.close()
        self.lease.give_back()

    def look(self) -> None:
        """Answer the bell."""
        self.rung += 1
        self._wake.set()

    def _guarded(self, name: str, loop: Callable[[], None]) -> None:
        """Run a loop for as long as we live; a store that is down is waited for."""
        while self.running:
            try:
                loop()
            except Error as error:
                log.warning("%s: the database does not answer: %s", name, error)
                close_old_connections()
                self.clock.sleep(0.5)
            except Exception:
                log.exception("%s failed and goes on", name)
                self.clock.sleep(0.5)

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
        """Keep the state where the keepers' page reads it."""
        kept = {"joints": list(state.joints), "pose": list(state.pose), "moving": state.moving, "ready": state.ready}
        Lease.objects.filter(robot=self.robot, epoch=self.lease.epoch).update(state=kept, state_at=self.now())

    def _renew(self) -> None:
        while self.running:
            begun = self.clock.monotonic()
            try:
                self.lease.renew()
            except Error:
                close_old_connections()
                self.clock.sleep(0.1)
                continue
            self.clock.sleep(max(0.1, begun + RENEW_S - self.clock.monotonic()))

    def _control(self) -> None:
        swept = 0.0
        while self.running:
            self._wake.wait(SWEEP_S)
            self._wake.clear()
            self.beat = self.clock.monotonic()
            if not self.lease.valid:
                regain(self, self._listen)
                continue
            if self.reach.connected:
                self._run_due()  # answer the bell before anything else
                if self.beat - swept < SWEEP_S:
                    continue
            swept = self.beat
            self._refresh()
            ledger.tidy(self.robot, self.lease.epoch, self.now())
            if not self.reach.connected:
                with self.taking(30.0):
                    self.reach.mend()
            self._run_due()
            if self.reach.connected and self.robot.cycle == Cycle.HANDOVER:
                with self.taking(180.0):
                    hand_over(self)
            self._look_if_unseen()

    def _look_if_unseen(self) -> None:
        """Where a motion was cut short or a picture failed, take the picture of where the robot rests."""
        state = self.driver.latest()
        resting = self.reach.connected and state is not None and not state.moving
        unseen = self.pictures.eyes and resting and self.pictures.still_id == 0
        if not unseen or self.robot.cycle == Cycle.HANDOVER or self.beat - self._looked < LOOK_AGAIN_S:
            return
        self._looked = self.beat
        with self.taking(30.0), contextlib.suppress(RobotError):
            self.executor.look(self.driver.state(), None)

    def _run_due(self) -> None:
        for command in ledger.due(self.robot, self.lease.epoch).select_related("grant"):
            if not self.running:
                return
            self._one(command)

    def _one(self, command: Command) -> None:
        command.robot = self.robot
        if not ledger.claim(command, self.lease.epoch, self.now()):
            return
        with self.taking(command.limit_s + 10.0):
            self.executor.run(command)

    def _refresh(self) -> None:
        """Follow changes of the robot's row: settings, cycle, address."""
        fresh = Robot.objects.get(pk=self.robot.pk)
        old = self.robot
        changed = (fresh.address, fresh.speed, fresh.boxes) != (old.address, old.speed, old.boxes)
        self.robot = fresh
        self.pictures.configure(fresh)
        if changed:
            self.driver.close()
            self.renew_driver()
            self.reach.later(0.0)
