"""The connection to the robot: opens the line, asks for the state, and repairs faults, again and again."""

import logging

from robots import bus
from robots.grants import open_grant
from robots.kit.contract.errors import HardwareFault, LineGone, LineSilent, NotPermitted, RobotError
from robots.kit.contract.session import RobotState
from robots.kit.packets import Changed, Notice
from robots.models import Command, Grant, Robot
from robots.services import asked_since_stop
from robots.services.incidents import TRIED_AGAIN, incident
from robots.states import Cycle, GrantKind
from workers.authority.lane import Lane
from workers.robot.owned import OwnedRobot
from workers.robot.recovery import Recovery

log = logging.getLogger(__name__)
AGAIN_S, REFUSED_S = 3.0, 10.0
BEGINS_S = 15.0  # the robot may be switched on together with its owner
STARTS = "The robot's simulator is starting."
AGAIN = "The robot answers again. Look at the picture, then go on."
NEXT = "The robot is not ready. Your next command resets it, and is not carried out; give it again then."


class Connection:
    """The connection to the robot, and the attempts to reconnect until the robot answers."""

    def __init__(self, owned: OwnedRobot, lane: Lane, recovery: Recovery) -> None:
        self._owned, self._lane, self._recovery = owned, lane, recovery
        self.connected = False
        self.times = 0  # that it was connected: each time the robot may have been another since
        self._retry_at = 0.0
        self._incident_at: float | None = None  # that it does not answer is an incident then; None: at once
        self._answers = False  # the line is open and the robot answers; it is only not permitted to mend it
        self._silent = False  # the line is open, and the robot was silent: it may boot because the line was opened

    def _ask(self, answers: bool = False) -> RobotState:
        """Open the line, unless the robot `answers` over it, and ask for the state; a robot that moves is held."""
        driver = self._owned.driver
        state = driver.state() if answers else driver.connect()
        return driver.hold() if state.moving else state

    def begin(self) -> None:
        """Connect for the first time; that it does not answer is an incident only if that goes on for 15 s."""
        self._incident_at = self._owned.clock.monotonic() + BEGINS_S
        self.connect()

    def connect(self, untouched: bool = False) -> None:
        """Connect under a new epoch; a robot that is not verified is not offered to people.

        `untouched`: it was ours all the time and at rest, so a robot that was in order still is.
        """
        owned = self._owned
        try:
            state = self._ask()
            self._opened()
        except RobotError as error:
            if owned.robot.reason == str(error):  # as the owner before this one has told
                self._incident_at = None
            begins = self._incident_at is not None
            log.log(logging.DEBUG if begins else logging.INFO, "no connection: %s (%s)", error, error.__cause__)
            self._unready(self._said(error), code="" if begins else error.code)
            self.later(2.0)
            self._leave(error)
            return
        owned.remember(state)
        cycle, reason = Robot.objects.values_list("cycle", "reason").get(pk=owned.robot.pk)
        if untouched and state.ready and cycle in (Cycle.READY, Cycle.OFFERED):
            return
        if cycle in (Cycle.OFFLINE, Cycle.FAULT, Cycle.READY, Cycle.OFFERED):
            owned.set_cycle(Cycle.HANDOVER, "", cycle)
        elif cycle == Cycle.OPERATING and not state.ready:  # mended under its grant, once a stop can be heard
            self._unready("The robot is not ready after its connection came back.", code=HardwareFault.code)
            self.later(0.0, answers=True)
        elif cycle == Cycle.OPERATING and reason:
            self._clear_reason()

    def _opened(self) -> None:
        self.connected, self._incident_at = True, None
        self.times += 1

    def _said(self, error: RobotError) -> str:
        """Return the words for an error; a simulator that is started together with its owner is no fault yet."""
        starts = self._incident_at is not None and isinstance(error, LineGone)
        return STARTS if starts and self._owned.robot.simulated else str(error)

    def later(self, seconds: float, answers: bool = False) -> None:
        """Try to mend the connection again in `seconds` (s); the line stays open where the robot `answers`."""
        self.connected, self._answers = False, answers
        self._retry_at = self._owned.clock.monotonic() + seconds

    def _leave(self, error: RobotError) -> None:
        """Close the line after a fault, unless the robot is only silent: then it is asked again over the open line."""
        self._silent = isinstance(error, LineSilent)
        if not self._silent:
            self._owned.driver.close()

    def faulted(self, error: HardwareFault, command: Command) -> None:
        """Recover after a fault during `command`; if that fails, the robot is in fault and later attempts follow."""
        if self._recovery.recover(error, command):
            self._opened()
            self._clear_reason()
            return
        self._unready(str(error))
        self._silent = isinstance(error, LineSilent)
        self.later(AGAIN_S)

    def lost_while_idle(self, error: HardwareFault) -> None:
        """Note that the hardware stopped answering while no command ran."""
        if self._owned.running and not self._lane.busy:
            log.warning("the robot: %s", error)
            self._unready(str(error), code=error.code)
            self._silent = isinstance(error, LineSilent)
            self.later(0.0)  # last: from now on the control loop mends it, and what that says is newer

    def failed_at_rest(self, fault: str) -> bool:
        """Take a robot back that answers with a fault while nobody has it. Return False if it is in use.

        Under a grant the next command reports the fault, and the robot is reset under that grant.
        """
        row = Robot.objects.filter(pk=self._owned.robot.pk, cycle__in=(Cycle.READY, Cycle.OFFERED))
        if self._lane.busy or not row.exists() or open_grant(self._owned.robot) is not None:
            return False
        self.lost_while_idle(HardwareFault(fault))
        return True

    def refuse(self, error: RobotError) -> None:
        """Let nothing move because of `error`, until the robot was connected again in ten seconds."""
        log.warning("nothing moves: %s", error)
        self._unready(str(error), code=error.code)
        self.later(REFUSED_S)

    def config_faulted(self, error: HardwareFault, command: Command) -> None:
        """Check the robot soon, because a command beside a motion failed; a running motion reports its own failure."""
        log.warning("%s of the robot: %s", command.kind, error)
        self.lost_while_idle(error)

    def mend(self) -> None:
        """Try again to connect and to put the robot in order; returns at once if it is not time yet."""
        owned, told = self._owned, AGAIN
        if owned.clock.monotonic() < self._retry_at:
            return
        answers, silent = self._answers, self._silent
        self.later(AGAIN_S)
        self._silent = False
        if not answers and not silent:
            owned.driver.close()
        try:
            state = self._ask(answers)
            grant = Grant.objects.filter(robot=owned.robot, ended_at=None).exclude(kind=GrantKind.REST).first()
            released = not self._lane.gate.authority.latch.latched and not asked_since_stop(owned.robot)
            if not state.ready and grant is not None and released:
                told = NEXT  # the release of a stop moves nothing
            elif not state.ready and grant is not None:
                self._lane.gate.open_for(grant)
                self._recovery.moves()
                state = owned.driver.recover(self._lane.gate.permit())
                told = self._recovery.words
        except NotPermitted as error:
            self._unready(str(error))
            self.later(AGAIN_S, answers=True)  # a stop that is latched is confirmed over the open line
            return
        except RobotError as error:
            self._leave(error)
            if self._incident_at is not None and owned.clock.monotonic() >= self._incident_at:
                self._incident_at, owned.robot.reason = None, ""
            told = self._said(error)
            self._unready(told, code="" if owned.robot.reason else error.code)  # once, not at each attempt
            return
        self._opened()
        owned.remember(state)
        self._clear_reason()
        owned.set_cycle(Cycle.HANDOVER, "", Cycle.FAULT)
        bus.publish(owned.robot.slug, Notice(told, "info"))

    def _clear_reason(self) -> None:
        robot = self._owned.robot
        Robot.objects.filter(pk=robot.pk).update(reason="")
        robot.reason = ""
        bus.publish(robot.slug, Changed("robot"))

    def _unready(self, text: str, code: str = "") -> None:
        robot = self._owned.robot
        if robot.reason != text and code:
            incident(robot, code, text, self._owned.now(), remedy=TRIED_AGAIN)
        robot.reason = text[:300]
        told = Robot.objects.filter(pk=robot.pk, enabled=True)  # one that is switched off is not at fault
        told.exclude(cycle__in=(Cycle.LOCKED_OUT, Cycle.OPERATING)).update(cycle=Cycle.FAULT)
        told.update(reason=robot.reason)
        bus.publish(robot.slug, Changed("robot"))
