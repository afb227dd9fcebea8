"""Measures where objects with printed markers are, in pictures of several fixed, calibrated cameras at once. Pure.

Each marker that is found is aligned with its print; a pose is fitted to all corners of an object in all cameras
together. A camera in which the detector has not read a marker helps too: the print is looked for where it would be.
Poses are 4 x 4 in the frame of the base; lengths in m.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from robots.kit.arms.pose import turned
from robots.kit.vision.alignment import HINT, READ_SURE, Grey, Template
from robots.kit.vision.markers import Markers
from robots.kit.vision.prints import FixedCamera, Floats, Print

FACING = 0.2  # cosine between a face and the way to the camera from which its print is looked for
SMALLEST_PX = 5.0  # edge of a marker in the picture from which its print is looked for
CLEAR_PX, NARROW_PX = 5.5, 5.0  # shortest edge and width of a marker of which at least a hint is seen
WORST_PX = 0.2  # root mean square of the corners' distances from those of the fitted pose
LEVEL, ALONE_LEVEL = np.radians((2.0, 12.0))  # an object that leans less lies level; one that one camera alone sees
ALONG_M = np.arange(-0.06, 0.0601, 0.003)  # of the way from one camera, on which another looks for the object
SAME_M = 0.012  # one camera alone tells no exact depth: an object is as high as one may be that is so near


Heights = Callable[[str, Floats], Sequence[float]]  # of an object by its name, about a pose
HeightsAt = Callable[[Floats], Sequence[float]]


@dataclass(frozen=True, eq=False)
class Seen:
    """A marker in one camera's picture; `corners`: (4, 2), px."""

    camera: FixedCamera
    print: Print
    corners: Floats


@dataclass(frozen=True)
class Measurement:
    """What pictures show: the pose of each object that was measured, the names of those of which a marker is seen.

    `cameras`: those in whose picture at least one marker is seen, so that it would show another one too.
    """

    poses: Mapping[str, Floats] = field(default_factory=dict)
    noticed: frozenset[str] = frozenset()
    cameras: tuple[FixedCamera, ...] = ()


class Measurer:
    """Measures objects with these prints, by name, in pictures of these cameras; `codes`: a dictionary's bits."""

    colour = False  # it is given grey pictures

    def __init__(
        self, cameras: Iterable[FixedCamera], prints: Mapping[str, Sequence[Print]],
        codes: Mapping[int, NDArray[np.uint8]],
    ) -> None:  # fmt: skip
        self.cameras, self.prints = {one.name: one for one in cameras}, prints
        self.names = tuple(prints)
        self._owner = {one.number: (name, one) for name, listed in prints.items() for one in listed}
        bits = {number: codes[number] for number in self._owner}
        sides = {number: one.side for number, (_, one) in self._owner.items()}
        self._templates = {number: Template(code) for number, code in bits.items()}
        self._detectors = {
            name: Markers({n: code.tolist() for n, code in bits.items()}, sides, camera.field)
            for name, camera in self.cameras.items()
        }

    def measure(
        self, pictures: Mapping[str, Grey], near: Mapping[str, Sequence[Floats]], heights: Heights
    ) -> Measurement:
        """Return what grey pictures show, by camera.

        `near`: where objects may be. `heights`: at which (m) the middle of an
        object may be that lies about there.
        Raises ValueError for a picture that is not of a camera's size.
        """
        seen = self._detect(pictures)
        poses, noticed = {}, set()
        for name in self.prints:
            known = seen.get(name, [])
            if known:
                noticed.add(name)
            pose = self._placed(known, near.get(name, ()), partial(heights, name), pictures, self.prints[name])
            if pose is not None:
                poses[name] = pose
            if pose is not None or self._hinted(near.get(name, ()), pictures, self.prints[name]):
                noticed.add(name)
        witnesses = {one.camera.name for listed in seen.values() for one in listed}
        return Measurement(poses, frozenset(noticed), tuple(c for name, c in self.cameras.items() if name in witnesses))

    def marks(self, camera: FixedCamera, name: str, pose: Floats) -> Iterator[Floats]:
        """Yield the points (n, 3) of each print of an object at a pose that a camera would see large enough."""
        for one in self.prints[name]:
            at = faced(camera, one, pose, CLEAR_PX)
            if at is not None and narrowest(at) >= NARROW_PX:
                yield np.vstack([one.corners, one.middle]) @ pose[:3, :3].T + pose[:3, 3]

    def _detect(self, pictures: Mapping[str, Grey]) -> dict[str, list[Seen]]:
        """Return the markers that are read, aligned, by object."""
        found: dict[str, list[Seen]] = {}
        for view, picture in pictures.items():
            camera = self.cameras[view]
            if picture.shape != camera.size[::-1]:
                raise ValueError(f"the camera {view} is described with pictures of {camera.size} pixels")
            for marker in self._detectors[view].find(picture):
                corners = self._templates[marker.number].align(picture, marker.corners, READ_SURE)
                if corners is not None:
                    name, one = self._owner[marker.number]
                    found.setdefault(name, []).append(Seen(camera, one, corners))
        return found

    def _placed(
        self, seen: list[Seen], near: Sequence[Floats], heights: HeightsAt, pictures: Mapping[str, Grey],
        prints: Sequence[Print],
    ) -> Floats | None:  # fmt: skip
        """Return the pose of one object, None where it is not certain; `seen` is added to."""
        if not seen:
            for start in near:
                self._complete(seen, start, pictures, prints)
                if seen:
                    return self._certain(seen, start, heights)
            return None
        pose = _fit(seen, _starts(seen, near))
        if len({one.camera.name for one in seen}) == 1:
            pose = self._along(seen[0].camera, level(pose), pictures, prints)
        self._complete(seen, pose, pictures, prints)
        return self._certain(seen, pose, heights)

    def _along(self, first: FixedCamera, pose: Floats, pictures: Mapping[str, Grey], prints: Sequence[Print]) -> Floats:
        """Return the pose on the way from the first camera at which another one sees the object best."""
        way = pose[:3, 3] - first.seat
        way /= np.linalg.norm(way)
        best, most = pose, 0.0
        for along in ALONG_M:
            tried = pose.copy()
            tried[:3, 3] += along * way
            likeness = sum(
                self._templates[one.number].likeness(pictures[camera.name], corners)
                for camera, one, corners in self._visible(tried, pictures, prints)
                if camera is not first
            )
            if likeness > most:
                best, most = tried, likeness
        return best

    def _visible(
        self, pose: Floats, pictures: Mapping[str, Grey], prints: Sequence[Print]
    ) -> list[tuple[FixedCamera, Print, Floats]]:
        """Return which prints of an object at a pose face which camera, and their corners (4, 2)."""
        cameras = [self.cameras[name] for name in pictures]
        return [
            (camera, one, at) for camera in cameras for one in prints if (at := faced(camera, one, pose)) is not None
        ]

    def _hinted(self, near: Sequence[Floats], pictures: Mapping[str, Grey], prints: Sequence[Print]) -> bool:
        """Return whether something like a marker of an object is seen where it may be: it is not gone for certain."""
        return any(
            self._templates[one.number].align(pictures[camera.name], at, HINT) is not None
            for pose in near
            for camera, one, at in self._visible(pose, pictures, prints)
        )

    def _complete(self, seen: list[Seen], pose: Floats, pictures: Mapping[str, Grey], prints: Sequence[Print]) -> None:
        """Add the markers that the detector has not read, where they would be."""
        known = {(one.camera.name, one.print.number) for one in seen}
        for camera, one, at in self._visible(pose, pictures, prints):
            if (camera.name, one.number) not in known:
                template, picture = self._templates[one.number], pictures[camera.name]
                corners = template.align(picture, template.most_alike(picture, at))
                if corners is not None and np.abs(corners - at).max() < 0.5 * np.ptp(at, axis=0).max():
                    seen.append(Seen(camera, one, corners))

    @staticmethod
    def _certain(seen: list[Seen], start: Floats, heights: HeightsAt) -> Floats | None:
        """Return the pose that fits all corners, without the worst markers; None where too few agree."""
        while seen:
            pose, certain = _fit(seen, [start]), True
            lies, height = level(pose), None
            if len({one.camera.name for one in seen}) == 1:
                height = min(heights(pose), key=lambda one, z=pose[2, 3]: abs(one - z), default=None)  # type: ignore[misc]
                certain = height is not None and abs(height - pose[2, 3]) < SAME_M
            if turned(lies, pose) < (LEVEL if height is None else ALONE_LEVEL):
                pose = _fit_level(seen, lies, height if certain else None)
            else:
                certain = certain and height is None
            off = np.array([_rms([one], pose) for one in seen])
            if np.sqrt(np.mean(off**2)) < WORST_PX:
                return pose if certain else None
            seen.pop(int(np.argmax(off)))
        return None


def faced(camera: FixedCamera, one: Print, pose: Floats, smallest: float = SMALLEST_PX) -> Floats | None:
    """Return the corners (4, 2) of a print on an object at a pose; None where a camera does not see it so large."""
    corners = one.corners @ pose[:3, :3].T + pose[:3, 3]
    way = camera.seat - corners.mean(axis=0)
    if pose[:3, :3] @ one.out @ way < FACING * np.linalg.norm(way):
        return None
    at = camera.project(corners)
    inside = np.isfinite(at).all() and (at > 1.0).all() and (at < np.array(camera.size) - 2.0).all()
    edges = np.linalg.norm(at - np.roll(at, 1, axis=0), axis=1)
    return at if inside and edges.min() >= smallest else None


def narrowest(corners: Floats) -> float:
    """Return how far the longest edges of a marker are apart in a picture (px), from its corners (4, 2)."""
    across, down = corners[2] - corners[0], corners[3] - corners[1]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    return float(abs(across[0] * down[1] - across[1] * down[0]) / 2 / edges.max())


def level(pose: Floats) -> Floats:
    """Return the pose with the axis of the object that is nearest to the vertical exactly vertical."""
    ups = pose[2, :3]
    axis = pose[:3, int(np.argmax(np.abs(ups)))]
    up = np.array([0.0, 0.0, np.sign(axis[2]) or 1.0])
    turn, _ = Rotation.align_vectors(up[None], axis[None])
    lies = pose.copy()
    lies[:3, :3] = turn.as_matrix() @ pose[:3, :3]
    return lies


def _off(seen: Sequence[Seen], pose: Floats) -> Floats:
    """Return how far (px) each corner is from that of the pose."""
    at = [one.camera.project(one.print.corners @ pose[:3, :3].T + pose[:3, 3]) - one.corners for one in seen]
    return np.nan_to_num(np.concatenate(at).ravel(), nan=BEHIND_PX)


def _rms(seen: Sequence[Seen], pose: Floats) -> float:
    return float(np.sqrt(2 * np.mean(_off(seen, pose) ** 2)))


def _fit(seen: Sequence[Seen], starts: Sequence[Floats]) -> Floats:
    """Return the pose of least squares; of several starts the best two are tried."""
    best = sorted(starts, key=lambda start: _rms(seen, start))[:2]
    tried = [
        least_squares(lambda x, s=s: _off(seen, _moved(s, x)), np.zeros(6), method="lm", x_scale=SCALE6) for s in best
    ]
    which = int(np.argmin([one.cost for one in tried]))
    return _moved(best[which], tried[which].x)


def _fit_level(seen: Sequence[Seen], lies: Floats, height: float | None) -> Floats:
    """Return the pose of least squares that only turns about the vertical; at a height (m), where one is given."""
    lies = lies.copy()
    if height is not None:
        lies[2, 3] = height
    free = [2, 3, 4] if height is not None else [2, 3, 4, 5]

    def moved(x: Floats) -> Floats:
        whole = np.zeros(6)
        whole[free] = x
        return _moved(lies, whole)

    start, scale = np.zeros(len(free)), SCALE6[free]
    return moved(least_squares(lambda x: _off(seen, moved(x)), start, method="lm", x_scale=scale).x)


BEHIND_PX = 1e4  # how far off a corner is that would be behind the camera
SCALE6 = np.array([0.1, 0.1, 0.1, 0.01, 0.01, 0.01])  # rad, m


def _moved(pose: Floats, by: Floats) -> Floats:
    """Return a pose turned by a rotation vector (rad) about the axes of the base, and shifted (m)."""
    moved = pose.copy()
    moved[:3, :3] = Rotation.from_rotvec(by[:3]).as_matrix() @ pose[:3, :3]
    moved[:3, 3] += by[3:]
    return moved


def _starts(seen: Sequence[Seen], near: Sequence[Floats]) -> list[Floats]:
    """Return poses from which to fit: those that may be, and both of a plane's (IPPE) by each marker alone."""
    starts = list(near)
    for one in seen:
        frame = np.eye(4)  # of the marker in the object's
        frame[:3, :3] = np.stack([one.print.right, one.print.upward, one.print.out], axis=1)
        frame[:3, 3] = one.print.middle
        half = one.print.side / 2
        square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
        _, turns, shifts, _ = cv2.solvePnPGeneric(
            square, one.corners, one.camera.matrix, None, flags=cv2.SOLVEPNP_IPPE_SQUARE
        )
        for turn, shift in zip(turns, shifts, strict=True):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], shift[:, 0]
            if np.isfinite(pose).all() and pose[2, 3] > 0.0:
                starts.append(np.linalg.inv(one.camera.towards) @ pose @ np.linalg.inv(frame))
    return starts or [np.eye(4)]
