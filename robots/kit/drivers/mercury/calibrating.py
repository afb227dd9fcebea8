"""The empirical calibration: moves by known steps, measures how the picture moves, fits (section 6.5)."""

from collections.abc import Callable
from typing import Any

from robots.kit.contract.errors import NotCalibrated
from robots.kit.contract.session import Permit, Session
from robots.kit.drivers.mercury.calibration import RESPONSE, Picture, Shift, entry, find_change, measure_shift
from robots.kit.vision.stability import Verdict

STEPS_M = ((0.018, 0.0), (0.0, 0.018), (-0.018, 0.0), (0.0, -0.018), (0.014, 0.014), (-0.014, 0.014))
HEIGHTS = ("up", "down")


def calibrate(session: Session, settle: Callable[[], Verdict], permit: Permit) -> dict[str, Any]:
    """Measure both heights around the present position and return the calibration.

    Blows one burst of air at the end; its mark shows where the nozzle is.

    Raises:
        NotCalibrated: the pictures are not good enough.
        HardwareFault, NotPermitted, CameraFault: from the robot and its camera.
    """

    def do(kind: str, **args: float) -> None:
        session.execute(kind, args, permit, lambda _: None)

    x, y = session.state().pose[:2]
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
    poses = {"down": session.state().pose}
    do("up")
    up_mark = find_change(before["up"], settle().picture)
    poses["up"] = session.state().pose
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
