"""Measures where cuboids of one colour each are, in pictures of fixed, calibrated cameras at once. Pure; lengths in m.

For objects without printed markers. A cuboid is looked for by its hue; each height at which it may lie gives one place
where its outline has the middle of the patch of its colour, and the place whose outlines agree best with the patches in
all cameras is chosen. Half-hidden ones agree with none, and are noticed only. The table `[colours]` of a description
says how pure their colours are at least (`saturation`), and which other colours as pure there are (`others`).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robots.kit.vision.measuring import Heights, Measurement
from robots.kit.vision.prints import FixedCamera, Floats

Bgr = NDArray[np.uint8]
Mask = NDArray[np.uint8]
HUES = 180  # OpenCV's hue counts two degrees each
DARKEST = 40  # grey levels of the brightest part of a colour; darker pixels have no certain hue
SHARE, WIDEST_DEG = 0.6, 30.0  # of the way to the next hue; of a hue's window to each side: dark faces differ in hue
SMALLEST_PX = 14  # of a patch
ALIKE = 0.62  # least share of outline and patch that is common to both
BETTER = 0.12  # by so much another place has to agree better than that where an object is believed to be
ON_NOTHING = 0.04  # so much better it has to agree where nothing is known to be beneath it
MOST_HIGH = 4  # objects on each other
SURE = 0.8  # a place that agrees so well is right
STEPS = 3  # in which the middle of an outline is brought to that of the patch
TURNS = np.radians((0.0, 15.0, 30.0, 45.0, 60.0, 75.0))
FINER = 4  # times the picture's resolution, in which outlines are compared
STAYED_M = 0.02  # an object that is seen farther than this from where it was has been moved
NEAR_M = 0.004  # a height that is nearer to one at which the object may lie is that one
MARGIN_PX = 3
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


@dataclass(frozen=True, eq=False)
class Patch:
    """The largest patch of a colour in one camera's picture: its pixels, and its middle (px)."""

    camera: FixedCamera
    mask: Mask
    middle: Floats


class ColourMeasurer:
    """Measures cuboids, each of a colour (red, green, blue, from 0 to 1) and a size (m) by its name.

    `saturation`: how pure a colour has to be at least (0 to 1). `others`: pure colours of other things.
    """

    names: tuple[str, ...]
    colour = True

    def __init__(
        self, cameras: Iterable[FixedCamera], cuboids: Mapping[str, tuple[Sequence[float], Sequence[float]]],
        saturation: float, others: Iterable[Sequence[float]] = (),
    ) -> None:  # fmt: skip
        self.cameras, self.names = {one.name: one for one in cameras}, tuple(cuboids)
        self._sizes = {name: np.array(size, np.float64) for name, (_, size) in cuboids.items()}
        self._hues = {name: _hue(colour) for name, (colour, _) in cuboids.items()}
        self._saturation = 255 * saturation
        hues = [*self._hues.values(), *map(_hue, others)]
        self._within = {
            name: min([WIDEST_DEG / 2, *(SHARE * _apart(hue, one) for one in hues if one != hue)])
            for name, hue in self._hues.items()
        }

    def measure(
        self, pictures: Mapping[str, Bgr], near: Mapping[str, Sequence[Floats]], heights: Heights
    ) -> Measurement:
        """Return what pictures (blue, green, red) show, by camera; as `Measurer.measure`."""
        poses, noticed, witnesses = dict[str, Floats](), set[str](), set[str]()
        hsv = {view: np.asarray(cv2.cvtColor(one, cv2.COLOR_BGR2HSV), np.uint8) for view, one in pictures.items()}
        for name in self.names:
            patches = [
                one for view in pictures if (one := self._patch(self.cameras[view], hsv[view], name)) is not None
            ]
            witnesses.update(one.camera.name for one in patches)
            places = near.get(name, ())
            pose = self._placed(name, patches, places, heights)
            if pose is not None:
                poses[name] = pose
            if pose is not None or any(self._is_at(name, one, place) for one in patches for place in places):
                noticed.add(name)
        return Measurement(poses, frozenset(noticed), tuple(c for name, c in self.cameras.items() if name in witnesses))

    def marks(self, camera: FixedCamera, name: str, pose: Floats) -> Iterator[Floats]:
        """Yield the points (n, 3) of an object at a pose of which a camera sees all if nothing hides it."""
        points = self.corners(name, pose)
        at = camera.project(points)
        inside = np.isfinite(at).all() and (at > 1.0).all() and (at < np.array(camera.size) - 2.0).all()
        if inside and cv2.contourArea(_outline(at)) >= 2 * SMALLEST_PX:
            top = points[np.argsort(points[:, 2])[4:]]
            yield np.vstack([top, top.mean(axis=0)])

    def _patch(self, camera: FixedCamera, hsv: Bgr, name: str) -> Patch | None:
        hue, saturation, value = (hsv[:, :, n].astype(np.int16) for n in range(3))
        apart = np.abs(hue - self._hues[name])
        apart = np.minimum(apart, HUES - apart)
        like = (apart <= self._within[name]) & (saturation >= self._saturation) & (value >= DARKEST)
        _, labels, stats, middles = cv2.connectedComponentsWithStats(like.astype(np.uint8), connectivity=8)
        if len(stats) < 2:
            return None
        largest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
        if stats[largest, cv2.CC_STAT_AREA] < SMALLEST_PX:
            return None
        mask = np.asarray(labels == largest, np.uint8)
        return Patch(camera, mask, np.asarray(middles[largest], np.float64))

    def corners(self, name: str, pose: Floats) -> Floats:
        """Return the corners (8, 3) of an object at a pose."""
        return np.asarray((CORNERS * self._sizes[name]) @ pose[:3, :3].T + pose[:3, 3])

    def _is_at(self, name: str, patch: Patch, pose: Floats) -> bool:
        """Tell whether a patch touches the outline of an object at a pose: something of it is seen there."""
        outline = _outline(patch.camera.project(self.corners(name, pose)))
        return (
            bool(np.isfinite(outline).all())
            and cv2.pointPolygonTest(outline, tuple(map(float, patch.middle)), True) > -MARGIN_PX
        )

    def _placed(self, name: str, patches: Sequence[Patch], near: Sequence[Floats], heights: Heights) -> Floats | None:
        """Return the pose that agrees best with the patches, None where none does; the believed one where it may be."""
        if not patches:
            return None
        patch = max(patches, key=lambda one: int(one.mask.sum()))
        best, most = None, ALIKE
        for start in near:
            pose = self._moved(name, patch, start)
            if (
                np.hypot(*(pose[:2, 3] - start[:2, 3])) < STAYED_M
                and (alike := self._alike(name, patches, pose)) > most
            ):
                best, most = pose, alike
        if most > SURE:
            return best
        most += BETTER if best is not None else 0.0
        for pose in self._turned(name, patches, patch, heights):
            alike = self._judged(name, patches, pose, heights)
            if alike > most:
                best, most = pose, alike
        return best

    def _turned(self, name: str, patches: Sequence[Patch], patch: Patch, heights: Heights) -> Iterator[Floats]:
        """Yield poses with the patch's middle: at the height that agrees best, by every turn."""
        floor, high = self._floor(name, patch, heights), self._sizes[name][2]
        levels = [self._moved(name, patch, _standing(patch, floor + high * n, TURNS[1])) for n in range(MOST_HIGH)]
        best = max(levels, key=lambda pose: self._judged(name, patches, pose, heights))
        for turn in TURNS:
            yield self._moved(name, patch, _standing(patch, float(best[2, 3]), turn))

    def _judged(self, name: str, patches: Sequence[Patch], pose: Floats, heights: Heights) -> float:
        """Return how much a pose agrees, less where nothing is known to be beneath it."""
        known = any(abs(height - pose[2, 3]) < NEAR_M for height in heights(name, pose))
        return self._alike(name, patches, pose) - (0.0 if known else ON_NOTHING)

    def _floor(self, name: str, patch: Patch, heights: Heights) -> float:
        """Return the lowest height at which the middle of an object may be where its patch is."""
        return min(heights(name, _standing(patch, self._sizes[name][2] / 2)))

    def _moved(self, name: str, patch: Patch, start: Floats) -> Floats:
        """Return a pose moved level, so that the middle of its outline is that of the patch."""
        pose = start.copy()
        wanted = patch.camera.on_level(patch.middle, float(pose[2, 3]))
        for _ in range(STEPS):
            middle = _middle(_outline(patch.camera.project(self.corners(name, pose))))
            pose[:2, 3] += (wanted - patch.camera.on_level(middle, float(pose[2, 3])))[:2]
        if not np.isfinite(pose).all():  # the way to the patch leads to no place so high
            return start
        return pose

    def _alike(self, name: str, patches: Sequence[Patch], pose: Floats) -> float:
        """Return how much outlines and patches have in common; cameras that see more of the object count more."""
        common = total = 0.0
        for one in patches:
            outline = _outline(one.camera.project(self.corners(name, pose)))
            if not np.isfinite(outline).all():
                return 0.0
            both, either = _shares(one.mask, outline)
            weight = sqrt(either)
            common, total = common + weight * both / either, total + weight
        return common / total if total else 0.0


def _hue(colour: Sequence[float]) -> float:
    pixel = np.array([[[255 * part for part in reversed(colour)]]], np.uint8)
    return float(cv2.cvtColor(pixel, cv2.COLOR_BGR2HSV)[0, 0, 0])


def _apart(one: float, other: float) -> float:
    return min(abs(one - other), HUES - abs(one - other))


def _standing(patch: Patch, height: float, turn: float = 0.0) -> Floats:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("z", turn).as_matrix()
    pose[:3, 3] = patch.camera.on_level(patch.middle, height)
    return pose


def _outline(at: Floats) -> Floats:
    """Return the outline (n, 1, 2) of projected corners (8, 2)."""
    return np.asarray(cv2.convexHull(at.astype(np.float32)), np.float32)


def _middle(outline: Floats) -> Floats:
    moments = cv2.moments(outline)
    area = moments["m00"] or 1.0
    return np.array([moments["m10"] / area, moments["m01"] / area])


def _shares(mask: Mask, outline: Floats) -> tuple[float, float]:
    """Return how many pixels an outline and a patch have in common, and in one of them."""
    rows, columns = np.nonzero(mask)
    low = np.floor(np.minimum(outline.min(axis=(0, 1)), (columns.min(), rows.min()))).astype(int) - 1
    high = np.ceil(np.maximum(outline.max(axis=(0, 1)), (columns.max(), rows.max()))).astype(int) + 2
    size = np.minimum(high - low, 400)
    shown = np.zeros((size[1] * FINER, size[0] * FINER), np.uint8)
    corners = np.round((outline[:, 0] - low + 0.5) * FINER - 0.5).astype(np.int32)
    cv2.fillConvexPoly(shown, corners, 1)
    patch = np.zeros((size[1], size[0]), np.uint8)
    at = (rows - low[1], columns - low[0])
    fits = (at[0] >= 0) & (at[0] < size[1]) & (at[1] >= 0) & (at[1] < size[0])
    patch[at[0][fits], at[1][fits]] = 1
    patch = cv2.resize(patch, (size[0] * FINER, size[1] * FINER), interpolation=cv2.INTER_NEAREST)
    return float((shown & patch).sum()) / FINER**2, float((shown | patch).sum()) / FINER**2
