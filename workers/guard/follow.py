"""The loops that query Redis and the database, so that safety is judged from memory."""

from robots import bus
from robots.grants import end_grant, open_grant, running_motions
from robots.kit.packets import Changed
from robots.states import GrantEnd, GrantKind
from workers.authority.gate import Authority
from workers.authority.lane import Lane, Pace
from workers.guard.stop import Stop
from workers.robot.owned import OwnedRobot

FOLLOW_S, IDLE_FOLLOW_S, IDLE_LINK_S = 0.1, 1.0, 0.5
LATE_S = 2.0  # a row may lag behind a time of day that was set; the gate lets nothing pass meanwhile


class Follower:
    """Keeps the state of Redis, of grants and of the stop in memory."""

    def __init__(
        self, owned: OwnedRobot, authority: Authority, lanes: tuple[Lane, ...], stop: Stop, pace: Pace
    ) -> None:
        self._owned, self._grants, self._link, self._lanes = owned, authority.grants, authority.link, lanes
        self._stop, self._pace = stop, pace

    def ask_link(self) -> None:
        """Ask Redis again and again whether it answers, until the owner ends."""
        while self._owned.running:
            asked = self._owned.clock.monotonic()
            if bus.alive():
                self._link.note_answer(asked)
            self._pace.sleep(FOLLOW_S, IDLE_LINK_S)

    def rows(self) -> None:
        """Read the rows of stop and grant again and again, until the owner ends."""
        while self._owned.running:
            self._stop.follow()
            self.follow_grant()
            self._pace.sleep(FOLLOW_S, IDLE_FOLLOW_S)

    def hold(self) -> None:
        """Hold again and again what the rows say is stopped and does not rest yet, until the owner ends."""
        while self._owned.running:
            self._owned.clock.wait(self._stop.due, FOLLOW_S if self._pace.lively else IDLE_FOLLOW_S)
            self._stop.hold_due()

    def follow_grant(self) -> None:
        """Learn which grant is open and until when; end it if nobody else does so when its time is up."""
        grants, robot, now = self._grants, self._owned.robot, self._owned.now
        # read before the query: a lane may open for the next grant meanwhile, which the answer does not contain
        known = {grants.newest, *(lane.gate.grant_id for lane in self._lanes)} - {0} - grants.ended_ids
        grant = open_grant(robot)
        for ended in known - {grant.pk if grant else 0}:  # only one is open at a time
            grants.revoke(ended)
        if grant is None:
            return
        self._pace.stir()
        grants.know(grant)  # a turn may have been extended
        if grants.late(grant.pk, LATE_S):
            end_grant(grant, GrantEnd.TIME_UP, "time is up", now())
            grants.revoke(grant.pk)
            bus.publish(robot.slug, Changed("queue"))
        elif grant.kind == GrantKind.REST and not running_motions(robot):  # the last one ended at rest
            end_grant(grant, GrantEnd.FINISHED, "at rest", now())
            bus.publish(robot.slug, Changed("queue"))
