"""Motions whose permit ends them on the way: held ones, and those that a newer target replaces."""

import logging

from django.db import Error, close_old_connections

from robots.contract.session import OnStage, Outcome, Permit
from robots.drivers.errors import ControlsReleased, Held, Replaced
from robots.models import Command
from workers.commands import claim
from workers.owned import OwnedRobot
from workers.safety.deadman import DeadManTimer
from workers.safety.lane import Lane
from workers.safety.lease import OwnerLease

log = logging.getLogger(__name__)


def replaceable(owned: OwnedRobot, lease: OwnerLease, lane: Lane, claimed: Permit) -> Permit:
    """Return a permit that ends when a newer target waits; a wake-up says when to look for one."""
    kinds = [c.kind for c in owned.robot.spec().commands if c.replaceable]
    looked = lane.wakes

    def permit() -> None:
        nonlocal looked
        claimed()
        if lane.wakes == looked or not lane.gate.has_begun:
            return  # before it has begun the line may be ours, and a hold must not wait for the stores
        looked = lane.wakes
        try:
            first = claim.due(owned.robot, lease.epoch, lane.name).first()
        except Error as error:
            log.warning("a newer target cannot be read, so this motion goes on: %s", error)
            close_old_connections()
            return
        if first is not None and first.kind in kinds:
            raise Replaced("Replaced: a newer target took its place.")

    return permit


def held_motion(
    owned: OwnedRobot, deadman: DeadManTimer, command: Command, claimed: Permit, on_stage: OnStage
) -> tuple[Outcome, str]:
    """Run a held motion until its controls are released; that is its good end unless they fell silent."""

    def permit() -> None:
        claimed()
        deadman.check()

    deadman.start(command)
    try:
        return owned.driver.execute(command.kind, command.args, permit, on_stage), "edge"
    except (ControlsReleased, Held):
        claimed()  # a stop, a lost grant: that is the reason then
        why = deadman.ended
        if why in ("", "lost"):
            raise Held("Nothing was heard from your controls, so the robot was held.") from None
        return Outcome({}, owned.driver.state()), why
    finally:
        deadman.end()
