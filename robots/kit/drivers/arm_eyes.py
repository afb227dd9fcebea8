"""Looks at the objects around an arm with its fixed, calibrated cameras: where they are, and which are gone.

An arm has such eyes if its `robot.toml` has `[[view]]`s and `markers` on its objects. Nothing is looked at by itself:
whoever wants to know calls `look`, so that an arm at rest costs nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.chain import Joints, Matrix
from robots.kit.arms.described import chain, limbs
from robots.kit.arms.hiding import Hiding
from robots.kit.arms.objects import objects_of, pose_of
from robots.kit.arms.solids import Solid
from robots.kit.contract.errors import CameraFault
from robots.kit.contract.session import Session
from robots.kit.description import load
from robots.kit.vision.alignment import Grey
from robots.kit.vision.measuring import Measurement, Measurer, faced
from robots.kit.vision.prints import FixedCamera, cameras_of, codes_of, prints_of
from robots.kit.vision.stability import BLACK

PAUSE_S = 30.0  # in which a camera that did not answer is asked only by who insists
CLEAR_PX = 7.0  # edge of a marker in a picture that is read for certain
NO_PICTURE, DARK = "the camera {} gives no picture", "the picture of the camera {} is black"
FROZEN = "the picture of the camera {} stands still"  # a sensor has noise: two pictures are never the same
NOTHING = "no marker can be read in the pictures"


@dataclass(frozen=True)
class Sight:
    """What a look has shown: measured poses (4 x 4) by name, and the names of those whose marker is seen at all.

    `missing`: those whose place is in view and not hidden, and whose markers are not there. `blind`: why nothing is
    known, as words for people; empty where something is.
    """

    poses: Mapping[str, Matrix] = field(default_factory=dict)
    noticed: frozenset[str] = frozenset()
    missing: frozenset[str] = frozenset()
    blind: str = ""


def eyes_of(session: Session, driver: str) -> "ArmEyes | None":
    """Return the eyes of an arm, None where its description has no calibrated cameras, or no markers."""
    description = load(driver)
    measurer = Measurer(cameras_of(description), prints_of(description), codes_of(description))
    return ArmEyes(session, driver, measurer) if measurer.cameras and measurer.prints else None


class ArmEyes:
    """Takes pictures through the session and measures the objects in them. One thread at a time."""

    def __init__(self, session: Session, driver: str, measurer: Measurer) -> None:
        self._session, self._measurer, self._table = session, measurer, objects_of(driver)
        arm = chain(driver)
        self._chain, self._hiding = arm, Hiding(arm, limbs(load(driver), arm), self._table)
        self._asked_again, self._last = dict[str, float](), dict[str, Grey]()

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
        first, blind = self._once(near, self._heights(arrangement), insists)
        missing = self._missing(first, believed, arrangement, q)
        if missing:  # one picture is no proof
            again, _ = self._once(near, self._heights(arrangement), insists)
            missing &= self._missing(again, believed, arrangement, q)
        return Sight(first.poses, first.noticed, frozenset(missing), "" if first.cameras else blind or NOTHING)

    def _once(
        self, near: Mapping[str, Sequence[Matrix]], heights: Mapping[str, Sequence[float]], insists: bool
    ) -> tuple[Measurement, str]:
        """Return what a picture of each camera shows, and why a camera shows nothing."""
        pictures, blind = dict[str, Grey](), []
        for name, camera in self._measurer.cameras.items():
            picture = self._picture(camera, insists)
            if (why := self._why_not(picture, self._last.get(name))) or picture is None:
                blind.append(why.format(name))
            else:
                pictures[name] = self._last[name] = picture
        return self._measurer.measure(pictures, near, heights), ", ".join(blind)

    @staticmethod
    def _why_not(picture: Grey | None, last: Grey | None) -> str:
        """Return why a picture shows nothing of the present, empty where it does."""
        if picture is None:
            return NO_PICTURE
        if float(picture.mean()) < BLACK:
            return DARK
        return FROZEN if last is not None and np.array_equal(picture, last) else ""

    def _picture(self, camera: FixedCamera, insists: bool) -> Grey | None:
        now = self._session.clock.monotonic()
        if not insists and now < self._asked_again.get(camera.name, -inf):
            return None
        try:
            picture = self._session.look(camera.name)
        except CameraFault:
            self._asked_again[camera.name] = now + PAUSE_S
            return None
        self._asked_again.pop(camera.name, None)
        return picture if picture.shape == camera.size[::-1] else None

    def _heights(self, arrangement: Arrangement) -> dict[str, list[float]]:
        """Return at which heights (m) the middle of each object may be: on the table, on others, where it was."""
        tops = [self._table.height, *(solid.top for _, solid in arrangement.lying())]
        found = {}
        for name, one in self._table.objects.items():
            solid = one.solid(pose_of(one.first))
            lies = [] if one.hangs else [top + (solid.top - solid.bottom) / 2 for top in tops]
            placed = arrangement.places.get(name)
            found[name] = lies if placed is None or placed.held else [*lies, placed.place[2]]
        return found

    def _missing(
        self, looked: Measurement, believed: Mapping[str, Matrix], arrangement: Arrangement, q: Joints
    ) -> set[str]:
        """Return the objects that are not noticed, though a camera that shows others would show them."""
        found = set()
        for name in self._measurer.prints:
            if name in looked.noticed or name not in believed:
                continue
            others = [solid for _, solid in arrangement.lying(name)]
            if any(self._shows(camera, name, believed[name], q, others) for camera in looked.cameras):
                found.add(name)
        return found

    def _shows(self, camera: FixedCamera, name: str, pose: Matrix, q: Joints, others: list[Solid]) -> bool:
        """Tell whether a camera would show a marker of an object at a pose."""
        for one in self._measurer.prints[name]:
            if faced(camera, one, pose, CLEAR_PX) is not None:
                points = np.vstack([one.corners, one.middle]) @ pose[:3, :3].T + pose[:3, 3]
                if not self._hiding.hides(q, others, camera.seat, points):
                    return True
        return False
