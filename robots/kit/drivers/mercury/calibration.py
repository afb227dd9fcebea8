"""From a click to a target: an affine map for each height, measured by moving and looking.

"A click on the camera image requires a different relative move if the camera is in the up
or down position. To handle it, we implemented an empirical calibration program" (Goldberg
et al. 1995, section 6.5).

A calibration is JSON: ``{"up": {"matrix": [[a, b, c], [d, e, f]], "z": m, "theta": rad,
"residual_mm": r, "points": n}, "down": {...}}``; (dx, dy) in m = matrix @ (u, v, 1), u and v
in pixels from the middle of the picture, v down.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.kit.contract.capabilities import PictureTaken
from robots.kit.contract.errors import BadRequest, NotCalibrated
from robots.kit.contract.session import Permit, Session
from robots.kit.vision.stability import Verdict

Picture = NDArray[np.uint8]
RESPONSE = 0.05  # a shift with a lower correlation peak is not used
OUTLIER_M = 0.002
STEPS_M = ((0.018, 0.0), (0.0, 0.018), (-0.018, 0.0), (0.0, -0.018), (0.014, 0.014), (-0.014, 0.014))
HEIGHTS = ("up", "down")


@dataclass(frozen=True)
class Shift:
    """A known motion of the tool (m) and how the picture moved (px)."""

    dx: float
    dy: float
    du: float
    dv: float


def measure_shift(before: Picture, after: Picture) -> tuple[float, float, float]:
    """Return (du, dv) in px that take `before` to `after`, and the response 0 to 1."""
    a, b = (cv2.GaussianBlur(p, (0, 0), 1.0).astype(np.float32) for p in (before, after))
    window = cv2.createHanningWindow((a.shape[1], a.shape[0]), cv2.CV_32F)
    (du, dv), response = cv2.phaseCorrelate(a - a.mean(), b - b.mean(), window)
    return float(du), float(dv), float(response)


def fit(shifts: list[Shift]) -> tuple[NDArray[np.float64], float]:
    """Return the 2 x 2 matrix from pixel offset to motion in m, and the residual RMS in mm.

    The picture moves against the tool: a point seen at offset p comes to the middle when the tool moves by M p, and the
    picture then shifts by -p.

    Raises:
        NotCalibrated: fewer than three usable shifts, or all on one line.
    """
    if len(shifts) < 3:
        raise NotCalibrated("Too few pictures could be compared; is the camera sharp and lit?")
    pixels = np.array([[-s.du, -s.dv] for s in shifts])
    moves = np.array([[s.dx, s.dy] for s in shifts])
    if np.linalg.matrix_rank(pixels, tol=1.0) < 2:
        raise NotCalibrated("The picture did not move in two directions.")
    solution = np.linalg.lstsq(pixels, moves, rcond=None)[0]
    off = np.hypot(*(pixels @ solution - moves).T)
    good = off <= max(OUTLIER_M, float(np.median(off)) * 3)
    if good.sum() >= 3 and not good.all():
        solution = np.linalg.lstsq(pixels[good], moves[good], rcond=None)[0]
        off = np.hypot(*(pixels[good] @ solution - moves[good]).T)
    return solution.T, float(np.sqrt(np.mean(off**2)) * 1000)


def find_change(before: Picture, after: Picture) -> tuple[float, float]:
    """Return where (u, v from the middle, px) the sand changed, which is the nozzle's place.

    The middle of the whole mark is shifted away from the light, the middle between its bright and its dark side is
    shifted towards the light; their mean is right within half a millimetre.

    Raises:
        NotCalibrated: nothing changed enough.
    """
    a, b = (cv2.GaussianBlur(p, (0, 0), 2.0).astype(np.float64) for p in (before, after))
    change = b - a
    if np.abs(change).max() < 8:
        raise NotCalibrated("The burst of air left no mark in the picture.")
    whole = _largest(np.abs(change))
    rows, columns = np.nonzero(whole)
    marks = [((columns.min() + columns.max()) / 2, (rows.min() + rows.max()) / 2)]
    around = cv2.dilate(whole.astype(np.uint8), np.ones((25, 25), np.uint8)) > 0
    flanks = [np.nonzero(_strong(np.where(around, sign * change, 0.0))) for sign in (1, -1)]
    marks.append(
        (
            sum(float(c.mean()) for _, c in flanks) / 2,
            sum(float(r.mean()) for r, _ in flanks) / 2,
        )
    )
    u, v = np.mean(marks, axis=0)
    return float(u) - (before.shape[1] - 1) / 2, float(v) - (before.shape[0] - 1) / 2


def _strong(strength: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(strength > strength.max() * 0.35)


def _largest(strength: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the largest connected area of strong change."""
    strong = cv2.morphologyEx(_strong(strength).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((9, 9), np.uint8))
    _, labels, stats, _ = cv2.connectedComponentsWithStats(strong)
    return np.asarray(labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])))


def entry(shifts: list[Shift], nozzle: tuple[float, float], z: float, theta: float) -> dict[str, Any]:
    """Return the calibration of one height; the nozzle's pixel is its zero."""
    matrix, residual = fit(shifts)
    offset = -matrix @ np.array(nozzle)
    return {
        "matrix": [[*map(float, matrix[0]), float(offset[0])], [*map(float, matrix[1]), float(offset[1])]],
        "z": z,
        "theta": theta,
        "residual_mm": round(residual, 3),
        "points": len(shifts),
    }


def height_name(calibration: dict[str, Any], z: float) -> str:
    """Return the entry for the height `z` (m). Raises NotCalibrated if there is none."""
    named = [(abs(e["z"] - z), name) for name, e in calibration.items() if isinstance(e, dict)]
    if not named or min(named)[0] > 0.005:
        raise NotCalibrated("The camera is not calibrated for this height yet.")
    return min(named)[1]


def target(
    calibration: dict[str, Any], pose: tuple[float, ...], u: float, v: float, width: int, height: int
) -> tuple[float, float]:
    """Return the tool target (x, y) in m that brings pixel (u, v) of a picture under the nozzle.

    The map turns with theta, so it is also right for a camera that is turned against the sand.
    """
    one = calibration[height_name(calibration, pose[2])]
    (a, b, c), (d, e, f) = one["matrix"]
    pu, pv = u - (width - 1) / 2, v - (height - 1) / 2
    dx, dy = a * pu + b * pv + c, d * pu + e * pv + f
    turn = pose[3] - one["theta"]
    return pose[0] + cos(turn) * dx - sin(turn) * dy, pose[1] + sin(turn) * dx + cos(turn) * dy


def calibrate(session: Session, settle: Callable[[], Verdict], permit: Permit) -> dict[str, Any]:
    """Measure both heights around the present position by known steps and return the calibration (section 6.5).

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


def resolve(picture: PictureTaken, u: float, v: float) -> tuple[str, dict[str, Any]]:
    """Return the move to the point (u, v) in px of the picture. Raises BadRequest."""
    try:
        x, y = target(dict(picture.calibration), picture.pose, u, v, picture.width, picture.height)
    except NotCalibrated as error:
        raise BadRequest(str(error)) from error
    return "move", {"x": x, "y": y}
