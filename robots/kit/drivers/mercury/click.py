"""Translates a click in a picture of the Mercury arm into a move."""

from typing import Any

from robots.kit.contract.capabilities import PictureTaken
from robots.kit.contract.errors import BadRequest, NotCalibrated
from robots.kit.drivers.mercury.calibration import target


def resolve(picture: PictureTaken, u: float, v: float) -> tuple[str, dict[str, Any]]:
    """Return the move to the point (u, v) in px of the picture. Raises BadRequest."""
    try:
        x, y = target(dict(picture.calibration), picture.pose, u, v, picture.width, picture.height)
    except NotCalibrated as error:
        raise BadRequest(str(error)) from error
    return "move", {"x": x, "y": y}
