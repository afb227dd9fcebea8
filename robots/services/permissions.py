"""Permissions beyond driving; each verb checks them itself."""

from typing import Any

from robots.kit.contract.errors import NotPermitted
from robots.kit.contract.spec import CommandKind
from robots.models import Robot

LEVEL = "robots.level_"  # followed by a number; the authentication backend compares the person's clearance with it


class NotStaff(NotPermitted):
    """The person is not staff of this robot."""


def need_staff(user: Any) -> None:
    """Check that the person may change robots. Raises NotStaff."""
    if user is None or not user.has_perm("robots.change_robot"):
        raise NotStaff("This is for staff who may change robots.")


class NotCleared(NotPermitted):
    """The person's clearance does not reach the level of the command."""

    code = "not_cleared"


def reaches(user: Any, robot: Robot, level: int) -> bool:
    """Return whether the person may give the robot commands of that level; level 1 needs no more than the turn."""
    if level <= 1:
        return True
    return user is not None and (user.has_perm("robots.change_robot") or user.has_perm(f"{LEVEL}{level}", robot))


def need_level(user: Any, robot: Robot, kind: CommandKind) -> None:
    """Check that the person may give this command. Raises NotCleared."""
    if not reaches(user, robot, kind.level):
        raise NotCleared(
            f"{kind.label} needs a clearance of level {kind.level} for this robot; staff can give it to you."
        )
