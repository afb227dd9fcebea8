"""Sets settings back before anything moves the robot, confirmed by its state.

These are settings that the last turn changed, and those that the robot has forgotten, as when it loses its power.
"""

from collections.abc import Callable, Mapping

from robots.grants import AnotherGrant, granted, open_grant
from robots.kit.contract.errors import HardwareFault, RobotError
from robots.kit.contract.spec import CommandKind
from robots.kit.contract.values import not_shown
from robots.models import Command, Grant, Robot
from robots.services import reset_settings, settings_to_reset
from robots.states import CommandState, Cycle, GrantKind
from workers.authority.lane import Lane
from workers.robot.connection import Connection
from workers.robot.owned import OwnedRobot

LIMIT_S = 180
POLL_S = 0.1


class SettingsReset:
    """Sets back the settings of one robot: at a handover, after the release of a stop, and after each connection.

    `run_beside` runs the commands that wait in the lane `beside`, in which settings are set.
    """

    def __init__(self, owned: OwnedRobot, connection: Connection, beside: Lane, run_beside: Callable[[], bool]) -> None:
        self._owned, self._lease, self._latch = owned, beside.lease, beside.gate.authority.latch
        self._connection, self._beside, self._run_beside = connection, beside, run_beside
        self._at = 0  # the connection after which it was judged what is to be set back
        self.put_off()  # what an earlier owner left is not known

    def put_off(self) -> None:
        """Note that a handover could set nothing back, because the robot is stopped: no motion before that is done."""
        self._owed: bool | None = None  # something is to be set back; None: not known

    def reset(self, grant: Grant) -> None:
        """Set changed settings back under an open grant. Raises HardwareFault if that is not confirmed."""
        owned, kinds, at = self._owned, self._owned.robot.spec().commands, self._connection.times
        rows = reset_settings(owned.robot, kinds, grant, self._lease.epoch, owned.now(), self._values)
        if rows:
            self._run_beside()
            with self._beside.paused(LIMIT_S):  # wait for a command that the lane's own thread has started
                pass
        for row in rows:
            row.refresh_from_db()
            if row.state != CommandState.COMPLETED:
                raise HardwareFault(f"The setting {row.kind} could not be set back: {row.reason}")
            self._confirm(next(kind for kind in kinds if kind.kind == row.kind), row)
        self._owed, self._at = False, at

    @property
    def _values(self) -> Mapping[str, float]:
        state = self._owned.driver.latest()
        return state.values if state is not None else {}

    def settle(self) -> bool:
        """Set back what is still to be set back. Return whether motions may run.

        It runs under the open turn, or under a grant of its own where there is none. What cannot be set back keeps
        everything from moving, and is tried again with the connection. Under the latch nothing is tried.
        """
        owned, times = self._owned, self._connection.times
        if self._owed is False and self._at == times:
            return True
        if Robot.objects.filter(pk=owned.robot.pk, cycle=Cycle.HANDOVER).exists():  # the owner's own row may be older
            return True
        if self._owed is None or self._at != times:
            robot, kinds = owned.robot, owned.robot.spec().commands
            self._owed, self._at = bool(settings_to_reset(robot, kinds, open_grant(robot), self._values)), times
        return not self._owed or (not self._latch.latched and self._reset_now())

    def _reset_now(self) -> bool:
        owned, grant = self._owned, open_grant(self._owned.robot)
        if grant is not None and grant.kind == GrantKind.UPKEEP:  # it ends with the one command of staff
            return True
        if grant is not None and grant.kind == GrantKind.REST:
            return False  # it ends soon
        try:
            if grant is not None:
                self.reset(grant)
            else:
                with granted(owned.robot, GrantKind.SETTINGS, owned.now, LIMIT_S) as own:
                    self.reset(own)
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
        while (wrong := not_shown(kind, row.args, owned.driver.state().values)) is not None:
            if owned.clock.monotonic() >= until:
                raise HardwareFault(f"The setting {row.kind} could not be set back: {wrong}")
            owned.clock.sleep(POLL_S)
