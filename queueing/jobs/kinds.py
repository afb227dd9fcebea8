"""The kinds of jobs that a robot takes, and from whom."""

from typing import Any

from accounts.services import cleared
from queueing.rows import link_of
from robots.kit.contract.find import spec_or_none
from robots.kit.contract.spec import ANYONE, CommandKind
from robots.models import Robot, words
from robots.services.commands import LIMIT_S


def offers_turns(robot: Robot) -> bool:
    """Return whether people may drive the robot."""
    link = link_of(robot)
    return link is None or link.offers_turns


def job_kinds(robot: Robot) -> tuple[CommandKind, ...]:
    """Return the command kinds that may be requested as jobs; none if the robot's package is not installed."""
    return job_kinds_or_none(robot) or ()


def job_kinds_or_none(robot: Robot) -> tuple[CommandKind, ...] | None:
    """Return the same, but None if the robot's package is not installed."""
    spec = spec_or_none(robot.driver)
    return None if spec is None else tuple(c for c in spec.commands if c.open_to(ANYONE) and not c.held)


def may_ask(robot: Robot, user: Any, kind: CommandKind, guests_ask: bool) -> bool:
    """Return whether this person, or a guest, may ask the robot for this kind of job.

    If guests may ask, every account may; otherwise the person needs the clearance for the kind's level.
    """
    signed_in = user is not None and user.is_authenticated
    if signed_in and (not user.is_active or user.guest):  # who practises without an account drives, and no more
        return False
    return guests_ask or (signed_in and cleared(user, robot, kind.level))


def kinds_for(robot: Robot, user: Any) -> tuple[CommandKind, ...]:
    """Return the kinds for which this person may ask now."""
    link = link_of(robot)
    guests = link is not None and link.guests_ask
    return tuple(kind for kind in job_kinds(robot) if may_ask(robot, user, kind, guests))


def label_of(robot: Robot, kind: str) -> str:
    """Return the robot's label of this kind of command; the kind's name if the robot no longer has it."""
    return words.label_of(robot.driver, kind)


def limit_of(robot: Robot, kind: str) -> float:
    """Return how long a command of this kind may take (s)."""
    found = _kind_of(robot, kind)
    return found.limit_s if found else LIMIT_S


def _kind_of(robot: Robot, kind: str) -> CommandKind | None:
    spec = spec_or_none(robot.driver)
    return spec.command(kind) if spec else None
