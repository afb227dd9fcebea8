"""Stills as the table `[camera]` of a `robot.toml` describes them."""

from collections.abc import Mapping
from typing import Any

from robots.kit.contract.capabilities import Stills


def stills(camera: Mapping[str, Any], brightness: str = "") -> Stills:
    """Return the capability; `brightness` names the class that corrects pictures, if there is one."""
    low, high = camera["exposure_range_s"]
    return Stills(
        settle_exposure_s=float(camera["stability_exposure_s"]), threshold=float(camera["stability_threshold"]),
        tries=int(camera["stability_tries"]), exposure_s=float(camera["delivery_exposure_s"]),
        exposure_range_s=(low, high), brightness=brightness,
    )  # fmt: skip
