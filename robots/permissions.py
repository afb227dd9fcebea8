"""Permissions of staff beyond driving; each verb asks for them itself."""

from typing import Any

from robots.drivers.errors import NotPermitted


class NotStaff(NotPermitted):
    """The person is not staff of this robot."""


def need_staff(user: Any) -> None:
    """Return if the person may change robots. Raises NotStaff."""
    if user is None or not user.has_perm("robots.change_robot"):
        raise NotStaff("This is for staff who may change robots.")
