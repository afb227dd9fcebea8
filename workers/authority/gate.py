"""The gate: may this process move the robot now? Asked last, before every actuation."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from math import inf
from typing import Literal

from robots.kit.clock import Clock
from robots.kit.contract.errors import GrantOver, NotPermitted, StaleEpoch, Stopped, TooLate
from robots.kit.contract.policies import HOLD, Bound, Policies
from robots.kit.contract.session import Permit
from robots.models import Command, Grant
from robots.states import ONE_COMMAND
from workers.authority.lease import OwnerLease
from workers.authority.memory import KnownGrants, Link, StopLatch

BEFORE_S = 0.5  # a command must be sent this long before its deadline, because the robot has to plan it
LAPSED = "The robot's worker lost control of the robot for a moment; this command was not carried out."
TURN_OVER = "The turn is over."
ONE_OVER = "The robot's time for this is over."  # nobody had a turn
TOO_LATE = "The command came too late and was not carried out."
Why = Literal["", "link", "grant"]


class LinkDown(NotPermitted):
    """The live link is down: nobody could stop the robot past the queue."""

    code = "link_down"


@dataclass(frozen=True)
class KnownState:
    """The robot's present values by name, its velocities (rad/s, m/s) and its rate of turn (rad/s), as far as known."""

    values: Mapping[str, float]
    velocities: tuple[float, ...] = ()
    turn: float | None = None


def inside(bound: Bound, known: KnownState | None) -> bool:
    """Tell whether the robot is known to be inside the bound's area and speed."""
    if known is None:
        return not bound.area and bound.speed is None and bound.turn is None
    if not all(r.low <= known.values.get(r.name, inf) <= r.high for r in bound.area):
        return False
    speed, turn = bound.speed, bound.turn
    if speed is not None and not (known.velocities and all(abs(v) <= speed for v in known.velocities)):
        return False
    return turn is None or (known.turn is not None and abs(known.turn) <= turn)


def why_held(policies: Policies, now: float, lost_at: float | None, until: float, known: KnownState | None) -> Why:
    """Return why a motion has to be held now: for its grant, for the connection; empty while it may go on.

    Times are monotonic (s): `lost_at` since when the connection is lost (None: it is not), `until` when the
    grant ends.
    """
    if not now < until:
        return "grant"
    if lost_at is not None:
        alone = policies.on_link_lost
        if alone is None or not now < lost_at + alone.seconds or not inside(alone, known):
            return "link"
    last = policies.on_grant_end
    if last is not None and now >= until - last.seconds and not inside(last, known):
        return "grant"
    return ""


@dataclass(frozen=True)
class Authority:
    """By what this process may move its robot: lease, latch, link and the knowledge of grants, shared by all lanes."""

    clock: Clock
    lease: OwnerLease
    latch: StopLatch
    link: Link
    grants: KnownGrants


@dataclass
class Gate:
    """Checks lease, latch, link, grant and deadline from memory; each lane has one, for the command that it runs."""

    authority: Authority
    known_state: Callable[[], KnownState | None]  # the robot's present values
    grant_id: int = 0
    over: str = TURN_OVER  # what a command of that grant is told after its end
    begin_by: float | None = None
    policies: Policies = HOLD  # of the command that runs

    def open_for(self, grant: Grant) -> None:
        """Let commands of `grant` pass until it ends."""
        self.authority.grants.know(grant)
        self.grant_id = grant.pk
        self.over = ONE_OVER if grant.kind in ONE_COMMAND else TURN_OVER

    def expect(self, command: Command, now: datetime) -> None:
        """Let a claimed command start until shortly before its deadline, even if the time of day was set back since."""
        left = min(command.deadline - now, command.deadline - command.created_at)
        self.begin_by = self.authority.clock.monotonic() + left.total_seconds() - BEFORE_S

    def note_begun(self) -> None:
        """Note that the robot has acknowledged the command, or that none is to start any more."""
        self.begin_by = None

    @contextmanager
    def command(self, command: Command, now: datetime) -> Iterator[Permit]:
        """Let a claimed command move the robot while the block runs; the permit is asked before each actuation.

        After the block any reason holds the robot.
        """
        self.open_for(command.grant)
        self.expect(command, now)
        if command.grant.ended_at is not None:
            self.authority.grants.revoke(command.grant_id)
        try:
            yield self.permit(command.epoch)
        finally:
            self.policies = HOLD

    @property
    def has_begun(self) -> bool:
        """Return whether no command has still to start."""
        return self.begin_by is None

    @property
    def time_left(self) -> float:
        """Return for how long (s) the command that runs may still move, as far as is known now."""
        now, until, lost_at = self._now, self.authority.grants.until(self.grant_id), self.authority.link.lost_at
        alone = self.policies.on_link_lost
        if lost_at is not None:
            until = min(until, lost_at + (alone.seconds if alone is not None else 0.0))
        allowed = self.authority.lease.valid and not self.authority.latch.latched
        return max(0.0, until - now) if allowed else 0.0

    @property
    def grant_over(self) -> bool:
        """Return whether the grant that may pass has ended."""
        return self.authority.grants.over(self.grant_id)

    @property
    def forbidden(self) -> bool:
        """Return whether a running command has to be held. The latch is not asked, because a stop holds by itself."""
        return not self.authority.lease.valid or self._why() != ""

    @property
    def _now(self) -> float:
        return self.authority.clock.monotonic()

    def _why(self) -> Why:
        """Return why a running command has to be held; without a link nothing starts, whatever its policies allow."""
        policies = self.policies if self.has_begun else HOLD
        known = None if policies == HOLD else self.known_state()
        until = self.authority.grants.until(self.grant_id)
        return why_held(policies, self._now, self.authority.link.lost_at, until, known)

    def permit(self, epoch: int | None = None) -> Permit:
        """Return a permit for one epoch, else for the present one: once the lease has run out, it refuses for ever."""
        lease = self.authority.lease
        meant = lease.epoch if epoch is None else epoch

        def permit() -> None:
            self.check()
            if lease.epoch != meant:
                raise StaleEpoch(LAPSED)

        return permit

    def check(self) -> None:
        """Return if the robot may move. Raises StaleEpoch, Stopped, LinkDown, GrantOver, TooLate."""
        if not self.authority.lease.valid:
            raise StaleEpoch(LAPSED)
        if self.authority.latch.latched:
            raise Stopped("The robot is stopped.")
        why = self._why()
        if why == "link":
            raise LinkDown("The live link is down, so nothing moves until it is back.")
        if why == "grant":
            raise GrantOver(self.over)
        if self.begin_by is not None and self._now >= self.begin_by:
            raise TooLate(TOO_LATE)
