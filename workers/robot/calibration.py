"""Runs the calibration that a robot declares and stores its result in the robot's row."""

from typing import Any

from robots.kit.contract.capabilities import Calibration
from robots.kit.contract.errors import BadRequest, NotCalibrated, RobotError
from robots.kit.contract.find import function
from robots.kit.contract.session import Permit
from robots.models import Robot
from workers.door import Door, Ours
from workers.media.pictures import Pictures
from workers.robot.owned import OwnedRobot


def calibrate_and_keep(owned: OwnedRobot, pictures: Pictures, permit: Permit) -> dict[str, Any]:
    """Measure, store and return the calibration. Raises BadRequest, NotCalibrated and the errors of drivers."""
    declared = owned.robot.spec().capability(Calibration)
    if declared is None:
        raise BadRequest("This robot has no calibration.")
    ours = Ours()
    with Door(NotCalibrated, "The calibration failed").open(RobotError, ours=ours):
        found: dict[str, Any] = function(declared.procedure)(owned.driver, pictures.settle, ours.of(permit))
    Robot.objects.filter(pk=owned.robot.pk).update(calibration=found, calibrated_at=owned.now())
    owned.robot.refresh_from_db()
    pictures.configure(owned.robot)
    return found
