"""Who may do what to a robot beyond driving it; asked by each verb itself, wherever it is called from."""

from typing import Any

from robots.drivers.errors import NotPermitted


class NotStaff(NotPermitted):
    """The person is not on this robot's staff."""


def need_staff(user: Any) -> None:
    """Refuse everybody who may not change robots. Raises NotStaff."""
    if user is None or not user.has_perm("robots.change_robot"):
        raise NotStaff("This is for staff who may change robots.")
