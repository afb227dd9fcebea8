"""Settings that the last turn changed are set back before anybody else moves the robot, confirmed by its state."""

from collections.abc import Mapping
from typing import Any

from robots.contract.errors import HardwareFault, RobotError
from robots.contract.spec import CommandKind
from robots.grants import AnotherGrant, granted, open_grant
from robots.models import Command, Grant
from robots.services import restore, to_restore
from robots.states import CommandState, Cycle, GrantKind
from workers.commands.claim import Commands
from workers.connection import Connection
from workers.owned import OwnedRobot
from workers.safety.lease import OwnerLease
from workers.safety.memory import StopLatch

LIMIT_S = 180
POLL_S = 0.1
NEAR = 0.01  # of an argument's range: so far what the robot shows may be from what was set


class Restoring:
    """Sets back the settings of one robot: at a handover, or at the release of a stop that kept a handover from it."""

    def __init__(
        self, owned: OwnedRobot, lease: OwnerLease, latch: StopLatch, connection: Connection,
        motion: Commands, config: Commands,
    ) -> None:  # fmt: skip
        self._owned, self._lease, self._latch = owned, lease, latch
        self._connection, self._motion, self._config = connection, motion, config
        self.put_off()  # what an earlier owner left is not known

    def put_off(self) -> None:
        """Note that a handover could set nothing back, because the robot is stopped: no motion before that is done."""
        self._owed: bool | None = None  # something is to be set back; None: not known
        self._motion.before = self.settled

    def restore(self, grant: Grant) -> None:
        """Set changed settings back under an open grant. Raises HardwareFault if that is not confirmed."""
        owned, kinds = self._owned, self._owned.robot.spec().commands
        rows = restore(owned.robot, kinds, grant, self._lease.epoch, owned.now())
        if rows:
            self._config.run_due()
            with self._config.lane.paused(LIMIT_S):  # wait for a command that the lane's own thread has started
                pass
        for row in rows:
            row.refresh_from_db()
            if row.state != CommandState.COMPLETED:
                raise HardwareFault(f"The setting {row.kind} could not be set back: {row.reason}")
            self._confirm(next(kind for kind in kinds if kind.kind == row.kind), row)
        self._motion.before = None

    def settled(self) -> bool:
        """Set back what a stop kept from being set back. Return whether motions may run.

        It runs under the open turn, or under a grant of its own where there is none. What cannot be set back keeps
        everything from moving, and is tried again with the connection. Under the latch nothing is tried.
        """
        owned = self._owned
        if owned.robot.cycle == Cycle.HANDOVER:
            return True
        if self._owed is None:
            self._owed = bool(to_restore(owned.robot, owned.robot.spec().commands, open_grant(owned.robot)))
        if self._owed:
            return not self._latch.latched and self._settle()
        self._motion.before = None
        return True

    def _settle(self) -> bool:
        owned, grant = self._owned, open_grant(self._owned.robot)
        if grant is not None and grant.kind == GrantKind.UPKEEP:  # it ends with the one command of staff
            return True
        try:
            if grant is not None:
                self.restore(grant)
            else:
                with granted(owned.robot, GrantKind.SETTINGS, owned.now, LIMIT_S) as own:
                    self.restore(own)
        except AnotherGrant:
            return False  # somebody was given the robot at this moment
        except RobotError as error:
            if not self._latch.latched and self._lease.valid and (grant is None or open_grant(owned.robot) == grant):
                self._connection.refuse(error)
            return False
        return True

    def _confirm(self, kind: CommandKind, row: Command) -> None:
        """Wait until the robot shows what was set, where its spec says which channels do. Raises HardwareFault."""
        owned = self._owned
        until = owned.clock.monotonic() + kind.limit_s
        while (wrong := _not_shown(kind, row.args, owned.driver.state().values)) is not None:
            if owned.clock.monotonic() >= until:
                raise HardwareFault(f"The setting {row.kind} could not be set back: {wrong}")
            owned.clock.sleep(POLL_S)


def _not_shown(kind: CommandKind, args: Mapping[str, Any], values: Mapping[str, float]) -> str | None:
    """Return in words what a state shows otherwise than it was set; None if it shows everything."""
    for argument in kind.arguments:
        channel = kind.shown.get(argument.name)
        if channel is None or argument.name not in args:
            continue
        shown, wanted = values.get(channel), args[argument.name]
        if shown is None or not abs(shown - wanted) <= NEAR * (argument.high - argument.low):
            told = "nothing" if shown is None else f"{shown:g}"
            return f"the robot shows {told} for {channel}, not {wanted:g}."
    return None
