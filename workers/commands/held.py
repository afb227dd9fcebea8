"""Motions that their permit ends early: held motions, and motions that a newer target replaces."""

import logging
from functools import partial
from typing import Any

from django.db import Error, close_old_connections

from robots.kit.contract.errors import ControlsReleased, MotionHeld, MotionReplaced
from robots.kit.contract.session import OnStage, Outcome, Permit
from robots.kit.contract.values import check
from robots.models import Command
from workers.authority.lane import Lane
from workers.commands import rows
from workers.guard.deadman import DeadManTimer
from workers.robot.owned import OwnedRobot

log = logging.getLogger(__name__)
LOST = "Nothing was heard from your controls, so the robot was held."
UNHEARD = "Nothing was heard from your controls while this motion waited, so it did not begin."


def replaceable(owned: OwnedRobot, lane: Lane, claimed: Permit) -> Permit:
    """Return a permit that raises MotionReplaced once a newer target waits. It looks for one after each wake-up."""
    kinds = [c.kind for c in owned.robot.spec().commands if c.replaceable]
    looked = lane.wakes

    def permit() -> None:
        nonlocal looked
        claimed()
        if lane.wakes == looked or not lane.gate.has_begun:
            return  # until it has begun, this thread may hold the line's lock, and a hold must not wait for a query
        looked = lane.wakes
        try:
            first = rows.due(owned.robot, lane.lease.epoch, lane.name).first()
        except Error as error:
            log.warning("a newer target cannot be read, so this motion goes on: %s", error)
            close_old_connections()
            return
        if first is not None and first.kind in kinds:
            raise MotionReplaced("Replaced: a newer target took its place.")

    return permit


def _may_be_steered(owned: OwnedRobot, command: Command, args: dict[str, Any]) -> bool:
    """Tell whether a keep-alive may carry these values: those of the command's own, checked alike."""
    robot = owned.robot
    kind = robot.spec().command(command.kind)
    if kind is None or not kind.steered:
        return False
    try:
        check(robot.driver, command.kind, {**command.args, **args}, robot.driver_settings(), owned.driver.latest())
    except Exception:  # noqa: BLE001 - a package's own check; stops are heard in this thread
        return False
    return True


def held_motion(
    owned: OwnedRobot, deadman: DeadManTimer, command: Command, claimed: Permit, on_stage: OnStage
) -> tuple[Outcome, str]:
    """Run a held motion. Return its outcome and why it ended: `released`, `long`, or `edge` if the robot ended it.

    It does not begin if its controls were not heard a moment ago, or were released while it waited. Raises MotionHeld
    if the keep-alives ended, and the reason of the gate if that ended the motion.
    """

    def permit() -> None:
        claimed()
        deadman.check()

    deadman.start(command, partial(_may_be_steered, owned, command))
    begun = False
    try:
        permit()  # a driver may do more than ask before it moves
        begun = True
        return owned.driver.execute(command.kind, command.args, permit, on_stage), "edge"
    except (ControlsReleased, MotionHeld):
        claimed()  # if a stop or a lost grant ended it, that is the reason
        why = deadman.end_reason
        if why in ("", "lost"):
            raise MotionHeld(LOST if begun else UNHEARD) from None
        return Outcome({}, owned.driver.state()), why
    finally:
        deadman.end()
