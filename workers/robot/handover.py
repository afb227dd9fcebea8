"""Handover between two turns: home the robot, verify it by state and camera, then make it ready. Fails closed.

A robot that was stopped is not homed before somebody has released the stop and given a command.
"""

import logging

from robots.grants import AnotherGrant, end_grant, granted, open_grant
from robots.kit.contract.capabilities import Calibration
from robots.kit.contract.errors import (
    BadRequest,
    CameraFault,
    GaveUp,
    HardwareFault,
    OutOfWorkspace,
    RobotError,
    StaleEpoch,
)
from robots.kit.contract.session import Permit, RobotState
from robots.kit.contract.tidying import Tidy
from robots.models import Grant
from robots.services import asked_since_stop
from robots.services.incidents import NOT_OFFERED, incident, note_tidy, note_untidy
from robots.states import IN_ORDER, Cycle, GrantEnd, GrantKind
from workers.authority.gate import Gate
from workers.media.pictures import Pictures
from workers.robot.calibration import calibrate_and_keep
from workers.robot.connection import Connection
from workers.robot.owned import OwnedRobot
from workers.robot.settings import SettingsReset

log = logging.getLogger(__name__)
LIMIT_S = 180
STOPPED = "The robot moves although it is stopped."
RELEASED = "The robot moves although nobody has given it a command since its stop was released."


class Handover:
    """Puts one robot in order, under a grant of kind `handover`."""

    def __init__(
        self, owned: OwnedRobot, gate: Gate, pictures: Pictures, connection: Connection, settings_reset: SettingsReset
    ) -> None:
        self._owned, self._gate, self._latch = owned, gate, gate.authority.latch
        self._pictures, self._connection, self._settings_reset = pictures, connection, settings_reset

    @property
    def longest_s(self) -> float:
        """Return how long a handover may take now (s)."""
        return LIMIT_S + self._owned.robot.tidying_s()

    def hand_over(self) -> None:
        """Put the robot in order; it ends ready, or in fault with a reason."""
        owned, robot, now = self._owned, self._owned.robot, self._owned.now
        grant = open_grant(robot)
        if grant is not None and grant.kind in IN_ORDER:  # of an earlier owner that was interrupted
            end_grant(grant, GrantEnd.OWNER_LOST, "owner restarted", now())
            grant = None
        if grant is not None:
            return
        try:
            with granted(robot, GrantKind.HANDOVER, now, self.longest_s) as opened:
                self._put_in_order(opened)
        except StaleEpoch:  # the robot is in order; the handover is repeated under the new lease
            return
        except AnotherGrant:
            return
        except RobotError as error:
            incident(robot, error.code, str(error), now(), remedy=NOT_OFFERED)
            owned.set_cycle(Cycle.FAULT, f"It could not be put in order: {error}", Cycle.HANDOVER)
            self._connection.later(10.0)
        else:
            owned.set_cycle(Cycle.READY, "", Cycle.HANDOVER)

    def _put_in_order(self, grant: Grant) -> None:
        owned, pictures = self._owned, self._pictures
        self._gate.open_for(grant)
        permit = self._gate.permit()
        pictures.still_id = 0
        state = owned.driver.state()
        latched = self._latch.latched
        if not latched and asked_since_stop(owned.robot):
            state = self._homed(state, permit)
        elif state.moving:
            # A stop outlives the turn, and its release starts no motion: until somebody gives a command, only rest
            # and picture are verified.
            raise HardwareFault(STOPPED if latched else RELEASED)
        if latched:
            self._settings_reset.put_off()  # settings are set back at the release
        else:
            self._settings_reset.reset(grant)
        owned.remember(state)
        if not pictures.cameras:
            return
        frame, verdict = pictures.still(state, grant, None)
        if verdict.reason in ("black", "frozen", "camera stopped"):
            raise CameraFault(f"The camera is {verdict.reason}.")
        if frame is None:
            raise CameraFault("The picture could not be stored: the disk may be full.")

    def _homed(self, state: RobotState, permit: Permit) -> RobotState:
        """Home the robot from `state`, with reset and calibration if they are needed. Return the new state."""
        owned = self._owned
        if not state.ready:
            state = owned.driver.recover(permit)
        try:
            state = self._home(permit) or state
        except HardwareFault as error:
            log.warning("homing failed, resetting: %s", error)
            owned.driver.recover(permit)
            state = self._home(permit) or state
        if not owned.robot.calibration and owned.robot.spec().capability(Calibration) is not None:
            calibrate_and_keep(owned, self._pictures, permit)
            state = self._home(permit) or state
        return self._tidied(permit) or state

    def _tidied(self, permit: Permit) -> RobotState | None:
        """Tidy up, if the settings say so, and home the robot again; what is left is told staff, and no fault."""
        owned, tidy, seconds = self._owned, self._owned.robot.spec().capability(Tidy), self._owned.robot.tidying_s()
        if tidy is None or seconds < 1.0:
            return None
        try:
            owned.driver.execute(tidy.kind, {"seconds": seconds}, permit, lambda _: None)
        except (BadRequest, OutOfWorkspace, GaveUp) as error:
            note_untidy(owned.robot, str(error), owned.now())
        else:
            note_tidy(owned.robot, owned.now())
        return self._home(permit)

    def _home(self, permit: Permit) -> RobotState | None:
        driver, state = self._owned.driver, None
        for kind in self._owned.robot.spec().handover:
            state = driver.execute(kind, {}, permit, lambda _: None).state
        return state
