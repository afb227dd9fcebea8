"""Looks at the objects around an arm with its fixed, calibrated cameras: where they are, and which are gone.

An arm has such eyes if its `robot.toml` has `[[view]]`s and `markers` on its objects. Nothing is looked at by itself:
whoever wants to know calls `look`, so that an arm at rest costs nothing.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import inf, radians

import numpy as np
from numpy.typing import NDArray

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.chain import Joints, Matrix
from robots.kit.arms.described import chain, limbs
from robots.kit.arms.hiding import Hiding
from robots.kit.arms.objects import objects_of, pose_of
from robots.kit.arms.pose import turned
from robots.kit.arms.solids import Solid, is_over
from robots.kit.arms.swing import height
from robots.kit.contract.errors import CameraFault
from robots.kit.contract.session import Session
from robots.kit.description import load
from robots.kit.vision.colours import ColourMeasurer
from robots.kit.vision.measuring import LEVEL, Heights, Measurement, Measurer, level
from robots.kit.vision.prints import FixedCamera, cameras_of, codes_of, prints_of
from robots.kit.vision.stability import BLACK

BESIDE_M = 0.03  # what colours show farther from where it was may be as high as what is there, not as it was
PAUSE_S = 30.0  # in which a camera that did not answer is asked only by who insists
Picture = NDArray[np.uint8]
NO_PICTURE, DARK = "the camera {} gives no picture", "the picture of the camera {} is black"
FROZEN = "the picture of the camera {} stands still"  # a sensor has noise: two pictures are never the same
OTHER_SIZE = "the pictures of the camera {} are not as large as described"
NOTHING = "no marker can be read in the pictures"
EXACTLY, ROUGHLY = (0.0003, radians(0.3)), (0.006, radians(10.0))  # m, rad: what a measured place tells nothing new by


@dataclass(frozen=True)
class Sight:
    """What a look has shown: measured poses (4 x 4) by name, and the names of those whose marker is seen at all.

    `missing`: those whose place is in view and not hidden, and that are not there. `blind`: why nothing is known, as
    words for people; empty where something is. `same`: a place that differs by less (m, rad) from what is believed is
    no news.
    """

    poses: Mapping[str, Matrix] = field(default_factory=dict)
    noticed: frozenset[str] = frozenset()
    missing: frozenset[str] = frozenset()
    blind: str = ""
    same: tuple[float, float] = EXACTLY


def eyes_of(session: Session, driver: str) -> "ArmEyes | None":
    """Return the eyes of an arm, None where its description has no calibrated cameras, nor markers or colours."""
    description = load(driver)
    cameras, prints = cameras_of(description), prints_of(description)
    if cameras and prints:
        return ArmEyes(session, driver, Measurer(cameras, prints, codes_of(description)))
    if not cameras or "colours" not in description:
        return None
    boxes = {name: (one.colour, one.size) for name, one in objects_of(driver).objects.items()}
    rules = description["colours"]
    return ArmEyes(session, driver, ColourMeasurer(cameras, boxes, rules["saturation"], rules.get("others", ())))


class ArmEyes:
    """Takes pictures through the session and measures the objects in them. One thread at a time."""

    def __init__(self, session: Session, driver: str, measurer: Measurer | ColourMeasurer) -> None:
        self._session, self._measurer, self._table = session, measurer, objects_of(driver)
        arm = chain(driver)
        self._chain, self._hiding = arm, Hiding(arm, limbs(load(driver), arm), self._table)
        self._asked_again: dict[str, float] = {}

    @property
    def is_rough(self) -> bool:
        """Tell whether it measures to some millimetres only."""
        return self._measurer.colour

    def look(
        self, arrangement: Arrangement, q: Joints, insists: bool = False, or_at: Mapping[str, Matrix] | None = None
    ) -> Sight:
        """Return what the cameras show of the objects, which are believed to be arranged so; the arm rests at `q`.

        `insists`: also ask a camera that did not answer a moment ago. `or_at`: where objects may be too (4 x 4).
        """
        tool = self._chain.forward(q)
        believed = {name: pose_of(at) for name, at in arrangement.places.items()}
        believed = {name: tool @ at if arrangement.places[name].held else at for name, at in believed.items()}
        near = {name: [at] for name, at in believed.items()}
        for name, at in (or_at or {}).items():
            near.setdefault(name, []).append(at)
        heights = partial(self._heights, arrangement, believed)
        first, blind = self._once(near, heights, insists)
        missing = self._missing(first, believed, arrangement, q)
        if missing:  # one picture is no proof
            again, _ = self._once(near, heights, insists)
            missing &= self._missing(again, believed, arrangement, q)
        same, poses = EXACTLY, first.poses
        if isinstance(self._measurer, ColourMeasurer):
            same, poses = ROUGHLY, dict(self._unhidden(self._measurer, first, believed, q))
        return Sight(poses, first.noticed, frozenset(missing), "" if first.cameras else blind or NOTHING, same)

    def _unhidden(
        self, measurer: ColourMeasurer, looked: Measurement, believed: Mapping[str, Matrix], q: Joints
    ) -> Iterator[tuple[str, Matrix]]:
        """Yield what the nearest camera sees whole: the middle of a patch that is hidden in part is that of no box."""
        there = {**believed, **looked.poses}
        for name, pose in looked.poses.items():
            camera = min(looked.cameras, key=lambda one, at=pose[:3, 3]: float(np.linalg.norm(one.seat - at)))  # type: ignore[misc]
            others = [self._table.objects[other].solid(at) for other, at in there.items() if other != name]
            if not self._hiding.hides(q, others, camera.seat, measurer.corners(name, pose)):
                yield name, pose

    def _once(self, near: Mapping[str, Sequence[Matrix]], heights: Heights, insists: bool) -> tuple[Measurement, str]:
        """Return what a picture of each camera shows, and why a camera shows nothing."""
        pictures, blind = dict[str, Picture](), []
        for name, camera in self._measurer.cameras.items():
            picture, why = self._picture(camera, insists)
            if picture is None:
                blind.append(why.format(name))
            else:
                pictures[name] = picture
        return self._measurer.measure(pictures, near, heights), ", ".join(blind)

    def _picture(self, camera: FixedCamera, insists: bool) -> tuple[Picture | None, str]:
        """Return a picture, or None and why there is none of the present: of two, the second is new."""
        now = self._session.clock.monotonic()
        if not insists and now < self._asked_again.get(camera.name, -inf):
            return None, NO_PICTURE
        try:
            first, second = (self._session.look(camera.name, self._measurer.colour) for _ in range(2))
        except CameraFault:
            self._asked_again[camera.name] = now + PAUSE_S
            return None, NO_PICTURE
        self._asked_again.pop(camera.name, None)
        if first.shape[:2] != camera.size[::-1] or second.shape != first.shape:
            return None, OTHER_SIZE
        if float(second.mean()) < BLACK:
            return None, DARK
        if np.array_equal(first, second):
            return None, FROZEN
        return second, ""

    def glance(self, arrangement: Arrangement, name: str) -> tuple[float, Matrix | None] | None:
        """Return when (s, on the session's clock) one picture was taken and where one object was, None: not to be seen.

        A quick look at an object that moves: the pictures of two cameras are not of one moment. None without a picture
        in which markers can be read.
        """
        camera, placed = next(iter(self._measurer.cameras.values())), arrangement.places.get(name)
        at = self._session.clock.monotonic()
        try:
            picture = self._session.look(camera.name)
        except CameraFault:
            return None
        if placed is None or picture.shape != camera.size[::-1]:
            return None
        near = pose_of(placed)
        heights = partial(self._heights, arrangement, {name: near})
        found = self._measurer.measure({camera.name: picture}, {name: [near]}, heights)
        return (at, found.poses.get(name)) if found.cameras else None

    def _heights(
        self, arrangement: Arrangement, believed: Mapping[str, Matrix], name: str, pose: Matrix
    ) -> list[float]:
        """Return at which heights (m) the middle of an object may be that lies about a pose, or is where it was."""
        described, plate = self._table.objects[name], self._table.plate
        at, found = believed.get(name), list[float]()
        beside = 0.0 if at is None or not self._measurer.colour else float(np.hypot(*(at - pose)[:2, 3]))
        if (
            at is not None
            and beside < BESIDE_M
            and (not arrangement.places[name].held or turned(level(at), at) < LEVEL)
        ):
            found.append(float(at[2, 3]))  # what leans in the gripper has no height that one camera could use
        if described.threads is not None:
            found.append(height(described.threads[0], np.array(described.first.place), pose[:3, 3]))
        if described.hangs:
            return found
        solid, x, y = described.solid(pose_of(described.first)), float(pose[0, 3]), float(pose[1, 3])
        tops = [there.top for _, there in arrangement.lying(name) if is_over(there, x, y)]
        if plate is None or not is_over(plate.solid, x, y):
            tops.append(self._table.height)
        return found + [top + (solid.top - solid.bottom) / 2 for top in tops]

    def _missing(
        self, looked: Measurement, believed: Mapping[str, Matrix], arrangement: Arrangement, q: Joints
    ) -> set[str]:
        """Return the objects that are not noticed, though a camera that shows others would show them."""
        found, there = set(), {**believed, **looked.poses}
        for name in self._measurer.names:
            hangs = self._table.objects[name].threads is not None  # it may have swung out of view
            if name in looked.noticed or name not in believed or (hangs and not arrangement.places[name].held):
                continue
            others = [self._table.objects[other].solid(at) for other, at in there.items() if other != name]
            others += [self._table.plate.solid] if self._table.plate is not None else []
            if any(self._shows(camera, name, believed[name], q, others) for camera in looked.cameras):
                found.add(name)
        return found

    def _shows(self, camera: FixedCamera, name: str, pose: Matrix, q: Joints, others: list[Solid]) -> bool:
        """Tell whether a camera would show a marker of an object at a pose."""
        return any(
            not self._hiding.hides(q, others, camera.seat, points)
            for points in self._measurer.marks(camera, name, pose)
        )
