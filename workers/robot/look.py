"""The picture of the robot at rest, taken after a command."""

import logging
from typing import Any

from django.db import Error, close_old_connections

from robots.kit.contract.errors import CameraFault
from robots.kit.contract.session import RobotState
from robots.models import Command
from workers.media.pictures import Pictures
from workers.robot.owned import OwnedRobot

log = logging.getLogger(__name__)


def look(owned: OwnedRobot, pictures: Pictures, state: RobotState, command: Command | None) -> dict[str, Any]:
    """Take a stable picture and return the result; a camera that fails does not undo the motion."""
    try:
        owned.remember(state)
        if not pictures.cameras:
            return {"verdict": "no camera"}
        frame, verdict = pictures.still(state, command.grant if command else None, command)
    except CameraFault as error:
        return {"picture": None, "verdict": "no picture", "note": str(error)}
    except Error as error:
        log.warning("a picture could not be stored: %s", error)
        close_old_connections()
        return {
            "picture": None,
            "verdict": "no picture",
            "note": "The database did not store the picture.",
        }
    result: dict[str, Any] = {
        "verdict": verdict.reason,
        "stable": verdict.stable,
        "tries": verdict.tries,
        "difference": round(verdict.difference, 2),
    }
    if frame is None:
        result["note"] = "The picture could not be stored: the disk may be full."
    else:
        result |= {"picture": frame.url, "still": frame.pk}
    return result
