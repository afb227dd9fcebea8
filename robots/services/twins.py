"""Simulated twins, on which people practise before they drive the robot, or while they wait for it."""

from typing import Any

from robots.kit.contract.errors import BadRequest
from robots.kit.installed import simulators
from robots.models import Robot
from robots.services.permissions import need_staff
from robots.states import Cycle

GUEST_S = 60
LONGEST = Robot._meta.get_field("slug").max_length or 0


def twin_of(robot: Robot) -> Robot:
    """Make the simulator on which people practise for the robot; one that exists is returned as it is.

    Raises BadRequest for a robot without a simulator, and for one that is itself for practice.
    """
    if robot.practice:
        raise BadRequest(f"{robot} is for practice itself.")
    if robot.driver not in simulators():
        raise BadRequest(f"{robot} has no simulator; its package brings none.")
    found = robot.twins.first()
    if found is not None:
        return found
    return Robot.objects.create(
        slug=f"{robot.slug[: LONGEST - 9]}-practice", name=f"{robot.name[:71]} practice", driver=robot.driver,
        tagline=f"Learn here to drive {robot.name}. Nothing real moves.", address=f"sim:{robot.driver}",
        settings=robot.settings, turn_s=robot.turn_s, practice_for=robot, guest_s=GUEST_S, clearance_required=False,
        enabled=True, cycle=Cycle.HANDOVER,
    )  # fmt: skip


def add_twin(robot: Robot, user: Any) -> Robot:
    """Make the same for staff. Raises NotStaff, BadRequest."""
    need_staff(user)
    return twin_of(robot)
