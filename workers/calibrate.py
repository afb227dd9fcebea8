"""The empirical calibration: move by known steps, see how the picture moves, fit (section 6.5)."""

from collections.abc import Callable
from typing import Any

from robots.contract.session import Permit, Session
from robots.drivers.mercury.calibration import (
    RESPONSE,
    NotCalibrated,
    Picture,
    Shift,
    entry,
    find_change,
    measure_shift,
)
from robots.models import Robot
from robots.vision.stability import Verdict
from workers.cameras.pictures import Pictures
from workers.owned import OwnedRobot

STEPS_M = ((0.018, 0.0), (0.0, 0.018), (-0.018, 0.0), (0.0, -0.018), (0.014, 0.014), (-0.014, 0.014))
HEIGHTS = ("up", "down")


def calibrate_and_keep(owned: OwnedRobot, pictures: Pictures, permit: Permit) -> dict[str, Any]:
    """Measure the calibration, store it in the robot's row and return it. Raises as `calibrate` does."""
    found = calibrate(owned.driver, pictures.settle, permit)
    Robot.objects.filter(pk=owned.robot.pk).update(calibration=found, calibrated_at=owned.now())
    owned.robot.refresh_from_db()
    pictures.configure(owned.robot)
    return found


def calibrate(driver: Session, settle: Callable[[], Verdict], permit: Permit) -> dict[str, Any]:
    """Measure both heights around the present place and return the calibration.

    Blows one burst of air at the end: the mark it leaves shows where the nozzle is.

    Raises:
        NotCalibrated: the pictures do not tell enough.
        HardwareFault, NotPermitted, CameraFault: as the robot says.

    """

    def do(kind: str, **args: float) -> None:
        driver.execute(kind, args, permit, lambda _: None)

    x, y = driver.state().pose[:2]
    shifts: dict[str, list[Shift]] = {}
    before: dict[str, Picture] = {}
    for height in HEIGHTS:
        do(height)
        before[height] = settle().picture
        shifts[height] = [
            s for s in (_step(do, settle, before[height], x, y, *step) for step in STEPS_M) if s is not None
        ]
        do("move", x=x, y=y)
        before[height] = settle().picture
    do("air", seconds=0.3)
    down_mark = find_change(before["down"], settle().picture)
    poses = {"down": driver.state().pose}
    do("up")
    up_mark = find_change(before["up"], settle().picture)
    poses["up"] = driver.state().pose
    marks = {"up": up_mark, "down": down_mark}
    return {h: entry(shifts[h], marks[h], poses[h][2], poses[h][3]) for h in HEIGHTS}


def _step(
    do: Callable[..., None], settle: Callable[[], Verdict], before: Picture, x: float, y: float, dx: float, dy: float
) -> Shift | None:
    do("move", x=x + dx, y=y + dy)
    verdict = settle()
    if verdict.reason not in ("stable", "unstable"):
        raise NotCalibrated(f"The camera is {verdict.reason}.")
    du, dv, response = measure_shift(before, verdict.picture)
    return Shift(dx, dy, du, dv) if response > RESPONSE else None
