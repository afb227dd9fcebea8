"""Holding the robot when it may no longer move, and the stop.

The loop that holds asks no store: a database that stalls or a Redis that is gone cannot
keep it waiting. What it judges by is memory, written by the loops that do ask.
"""

import contextlib
import logging
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import redis

from robots import bus
from robots.drivers.errors import RobotError
from robots.grants import open_grant
from robots.messages import Changed
from robots.models import Grant, Robot
from workers import ledger

if TYPE_CHECKING:
    from workers.runtime import Runtime

log = logging.getLogger(__name__)
WATCH_S = 0.05
FOLLOW_S = 0.1


class Guard:
    """Four loops beside the control loop of `runtime`: watch, link, listen, follow."""

    def __init__(self, runtime: "Runtime", heartbeat: Path, on_lost: Callable[[], None]) -> None:
        self._runtime = runtime
        self._heartbeat = heartbeat
        self._on_lost = on_lost
        self._held = 0  # the command that was held last
        self._halting = threading.Lock()
        self._releases: int | None = None  # how many releases the row told of last
        self._at_rest = False  # the hold of the stop that is latched was confirmed
        self.trouble = ""  # a stop that the robot did not confirm, until it is written down
        self.pubsub: redis.client.PubSub | None = None

    def watch(self) -> None:
        """Hold what moves without a lease, a link or a grant; feed the heartbeat."""
        runtime, ours = self._runtime, True
        while runtime.running:
            if runtime.lease.lost:
                self.leave()
                return
            owned = runtime.lease.valid
            if ours and not owned:  # whatever the robot does: nobody may be told that it is ours
                log.warning("the lease of %s ran out: holding", runtime.robot.slug)
                with contextlib.suppress(RobotError, OSError):
                    runtime.driver.hold()
            ours = owned
            gate, state, command = runtime.gate, runtime.driver.latest(), runtime.current
            running = command is not None and command.pk != self._held
            forbidden = not owned or gate.link_down or gate.grant_over or runtime.hand.gone
            if forbidden and (running or (state is not None and state.moving)):
                self._held = command.pk if command is not None else self._held
                with contextlib.suppress(RobotError):
                    runtime.driver.hold()
            if runtime.sound:
                with contextlib.suppress(OSError):
                    self._heartbeat.touch()
            begun = runtime.clock.monotonic()
            runtime.clock.sleep(WATCH_S)
            woken = runtime.clock.monotonic()
            runtime.brownout.feel(woken - begun - WATCH_S, woken)

    def leave(self) -> None:
        """Leave the robot to the owner that has taken it."""
        runtime = self._runtime
        log.error("the lease of %s is lost to another owner: holding and leaving", runtime.robot.slug)
        runtime.running = False
        with contextlib.suppress(RobotError, OSError):
            runtime.driver.hold()
        runtime.driver.close()
        self._on_lost()

    def link(self) -> None:
        """Ask Redis whether it is there."""
        runtime = self._runtime
        while runtime.running:
            if bus.alive():
                runtime.gate.link_seen = runtime.clock.monotonic()
            runtime.clock.sleep(FOLLOW_S)

    def listen(self) -> None:
        """Hear stops, and the quick bell, on channels of their own."""
        runtime = self._runtime
        slug = runtime.robot.slug
        try:
            self.pubsub = bus.listener().pubsub(ignore_subscribe_messages=True)
            bell, held = bus.bell_channel(slug), bus.held_channel(slug)
            self.pubsub.subscribe(bus.stop_channel(slug), bell, held)
            while runtime.running:
                message = self.pubsub.get_message(timeout=1.0)
                channel = message["channel"].decode() if message else ""
                if message and channel == bell:
                    runtime.look()
                elif message and channel == held:
                    runtime.hand.feel(*bus.heard_keep(message["data"]))
                elif message and runtime.gate.heeds_stop_of(bus.heard_stop(message["data"])):
                    self.halt("bus")
        except (redis.RedisError, OSError, ValueError):
            runtime.clock.sleep(0.2)

    def halt(self, source: str) -> None:
        """Stop: hold the hardware, latch on disk. The row follows; no store is asked here."""
        runtime, latch = self._runtime, self._runtime.latch
        with self._halting:
            if latch.latched and self._at_rest:
                return  # pressed twice; a press that is heard late must not undo a release
            first = not latch.latched
            latch.forbid(self._releases)
            kept = threading.Thread(target=latch.keep, name="latch")  # a slow disk must not delay the hold
            kept.start()
            try:
                self._at_rest = not runtime.driver.hold().moving
            except RobotError as error:
                self._at_rest = False
                log.error("a stop could not be confirmed: %s", error)
                self.trouble = f"A stop could not be confirmed: {error}"
            kept.join()
        if first:
            log.info("stopped by %s", source)
            bus.publish(runtime.robot.slug, Changed("stop"))

    def follow(self) -> None:
        """Keep memory and rows together: the stop's latch, the end of a grant."""
        while self._runtime.running:
            self._follow_stop()
            self._follow_grant()
            self._runtime.clock.sleep(FOLLOW_S)

    def _follow_stop(self) -> None:
        runtime = self._runtime
        robot, latch = runtime.robot, runtime.latch
        if self.trouble:
            ledger.incident(robot, "stop_failed", self.trouble, runtime.now())
            self.trouble = ""
        in_row, releases = Robot.objects.values_list("stop_latched", "releases").get(pk=robot.pk)
        released = latch.releases is not None and releases > latch.releases
        self._releases = releases
        if in_row and not latch.latched:
            self.halt("row")
        elif in_row:
            latch.row_pending = False
        elif latch.latched and latch.row_pending and not released:
            Robot.objects.filter(pk=robot.pk).update(stop_latched=True)
            latch.row_pending = False
            bus.publish(robot.slug, Changed("stop"))
        elif latch.latched:
            with self._halting:  # not in the middle of a hold
                latch.release()
                self._at_rest = False
            bus.publish(robot.slug, Changed("stop"))

    def _follow_grant(self) -> None:
        runtime, gate = self._runtime, self._runtime.gate
        # read before we ask: the control loop may open for the next one meanwhile, of which the answer says nothing
        known = {gate.newest, gate.grant_id} - {0} - gate.revoked
        grant = open_grant(runtime.robot)
        for ended in known - {grant.pk if grant else 0}:  # one is open at a time
            gate.revoke(ended)
        if grant is None:
            return
        gate.know(grant, runtime.now())  # a turn may have been lengthened
        if grant.until is not None and grant.until <= runtime.now():
            Grant.objects.filter(pk=grant.pk, ended_at=None).update(ended_at=runtime.now(), end_reason="time is up")
            gate.revoke(grant.pk)
            bus.publish(runtime.robot.slug, Changed("queue"))
