"""The loops that ask the stores, so that safety is judged from memory."""

from robots import bus
from robots.grants import end_at_until, open_grant
from robots.messages import Changed
from workers.owned import OwnedRobot
from workers.safety.gate import Gate
from workers.safety.pace import Pace
from workers.safety.stop import Stop

FOLLOW_S, IDLE_FOLLOW_S, IDLE_LINK_S = 0.1, 1.0, 0.5


class Follower:
    """Keeps the gate informed of Redis and of grants, and the stop of its row."""

    def __init__(self, owned: OwnedRobot, gate: Gate, stop: Stop, pace: Pace) -> None:
        self._owned, self._gate, self._stop, self._pace = owned, gate, stop, pace

    def link(self) -> None:
        """Ask Redis whether it is there, for as long as the owner runs."""
        clock = self._owned.clock
        while self._owned.running:
            if bus.alive():
                self._gate.link_seen = clock.monotonic()
            self._pace.sleep(FOLLOW_S, IDLE_LINK_S)

    def rows(self) -> None:
        """Follow the rows of stop and grant, for as long as the owner runs."""
        while self._owned.running:
            self._stop.follow()
            self.follow_grant()
            self._pace.sleep(FOLLOW_S, IDLE_FOLLOW_S)

    def follow_grant(self) -> None:
        """Learn which grant is open and until when; end one whose time is up."""
        gate, robot, now = self._gate, self._owned.robot, self._owned.now
        # read before we ask: the control loop may open for the next one meanwhile, of which the answer says nothing
        known = {gate.newest, gate.grant_id} - {0} - gate.revoked
        grant = open_grant(robot)
        for ended in known - {grant.pk if grant else 0}:  # one is open at a time
            gate.revoke(ended)
        if grant is None:
            return
        self._pace.stir()
        gate.know(grant, now())  # a turn may have been lengthened
        if grant.until is not None and grant.until <= now():
            end_at_until(grant, now())
            gate.revoke(grant.pk)
            bus.publish(robot.slug, Changed("queue"))
