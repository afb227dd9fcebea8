"""The loop that publishes the robot's state, and asks for it if the robot has not sent it lately."""

import redis
from django.db import Error, close_old_connections

from robots import bus
from robots.kit.contract.compact import Layout
from robots.kit.contract.errors import HardwareFault
from robots.kit.contract.session import RobotState
from robots.kit.packets import state_packet
from workers.authority.lane import Pace
from workers.authority.memory import StopLatch
from workers.media.sound import Sound
from workers.media.streams import Streams
from workers.media.trace import WireTrace
from workers.robot.beat import RestBeat
from workers.robot.connection import Connection
from workers.robot.owned import OwnedRobot

STATE_HZ = 4  # if the description names no rate
TRACE_S = 0.25
ASK_S = 0.5
KEEP_S = 5.0  # between two writings of the channels
UNHEARD_S = 1.0  # between two states of an idle robot that nobody hears
WHOLE_S = 5.0  # between two states with everything for those who want compact ones


class StatePublisher:
    """Publishes the newest state several times a second."""

    def __init__(
        self, owned: OwnedRobot, connection: Connection, latch: StopLatch, trace: WireTrace, pace: Pace,
        streams: Streams, sound: Sound,
    ) -> None:  # fmt: skip
        self._owned, self._connection, self._latch, self._trace, self._pace = owned, connection, latch, trace, pace
        self._streams, self._sound = streams, sound
        self._heard = True
        self._number = 0
        self._spec = owned.robot.spec()
        self._packed = self._spec.packed()
        self._layout = Layout.of(self._spec)
        self._beat = RestBeat(self._layout) if self._layout is not None else None
        self._compact, self._whole = False, 0.0  # whether somebody wants compact states; when a whole one was sent
        self._kept = 0.0
        self._noted = False  # the fault that the robot shows has been dealt with

    def loop(self) -> None:
        """Publish until the owner ends."""
        owned, asked, looked = self._owned, 0.0, 0.0
        every = 1.0 / float(owned.robot.description().get("motion", {}).get("state_hz", STATE_HZ))
        while owned.running:
            self._pace.sleep(every, every if self._heard else UNHEARD_S)
            if self._owned.clock.monotonic() - looked >= TRACE_S:
                looked = self._owned.clock.monotonic()
                self._trace.look()
                self._look()
            heard = owned.driver.latest()
            quiet = heard is None or owned.age(heard) >= ASK_S
            if self._connection.connected and quiet and self._owned.clock.monotonic() - asked >= ASK_S:
                asked = self._owned.clock.monotonic()
                try:
                    owned.driver.state()
                except HardwareFault as error:
                    self._connection.lost_while_idle(error)
            state = owned.driver.latest()
            if state is not None:
                self._publish(state)
                self._keep(state)
                self._note_fault(state)
            self._streams.publish()

    def _keep(self, state: RobotState) -> None:
        """Keep the values of channels in the lease's row now and then: needs are judged by them, pages show them."""
        if not self._packed or self._owned.clock.monotonic() - self._kept < KEEP_S:
            return
        self._kept = self._owned.clock.monotonic()
        try:
            self._owned.remember(state)
        except Error:  # the database is away: the next one is kept
            close_old_connections()

    def _note_fault(self, state: RobotState) -> None:
        """Have a robot that shows a fault at rest taken back, once; not one under a stop: its release moves nothing."""
        if not state.fault:
            self._noted = False
        elif self._connection.connected and not self._noted:
            try:
                self._noted = self._latch.latched or self._connection.failed_at_rest(state.fault)
            except Error:  # the database is away: it is asked again
                close_old_connections()

    def _look(self) -> None:
        """Find out whether somebody wants compact states, or listens."""
        try:
            self._compact = self._heard and bus.watched(self._owned.robot.slug, "compact")
            if self._heard:
                self._sound.look(self._owned.robot)
        except (redis.RedisError, OSError):
            self._compact = False

    def _publish(self, state: RobotState) -> None:
        self._number += 1
        at_ms = int((self._owned.now().timestamp() - self._owned.age(state)) * 1000)
        latched, told = self._latch.latched, self._spec.named(state)
        packet = state_packet(self._number, at_ms, state, latched, self._packed, told, self._spec.body(state))
        self._heard = bus.publish_state(self._owned.robot.slug, packet)
        if not self._compact:
            return
        compact = None
        silent = self._owned.age(state) > WHOLE_S  # its stamp would soon be taken for a later one
        if self._layout is not None and not silent and self._owned.clock.monotonic() - self._whole < WHOLE_S:
            if self._beat is not None and not self._beat.due(state, latched, told, self._owned.clock.monotonic()):
                return
            compact = self._layout.encode(at_ms, state, latched, told)
        if compact is None:
            self._whole = self._owned.clock.monotonic()
        bus.publish_compact(self._owned.robot.slug, compact or packet)
