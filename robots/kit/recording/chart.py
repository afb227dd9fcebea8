"""Draws a path from above: floor or table, the path planned and driven, the robot, and where pictures were taken.

Colours of Okabe and Ito, which people with any colour vision tell apart; planned and driven differ in their lines too.
Pixels are red, green, blue. No Django.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import cos, dist, pi, sin
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.kit.contract.floor import Box, Floor
from robots.kit.recording.captions import TOGETHER
from robots.kit.recording.marks import Marks
from robots.kit.recording.paths import JUMP_M, Line, Place, PoseReading

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]
PAPER, WALL, THING, INK, QUIET = (255, 255, 255), (90, 90, 90), (205, 205, 205), (20, 20, 20), (95, 95, 95)
DRIVEN, PLANNED, TAKEN = (0, 114, 178), (230, 159, 0), (213, 94, 0)
TARGET, DONE = (0, 158, 115), (204, 121, 167)
LEGEND = 40  # px below the plot
DASH, GAP = 8, 7  # px
MARGIN = 10  # px around the plot
ROBOT, BESIDE = 11, 12  # px from the robot's middle to its nose; from a picture's place to its number
ROW, WORK = 16, 9  # px from a row of the legend to the next; of a mark of work, which an arm's tool does not cover
_FACE: list[Any] = []


def text(picture: Picture, words: str, at: tuple[int, int], size: int, colour: Colour) -> int:
    """Write words from a point of their base line on; return where they end (px)."""
    cv2.putText(picture, words.replace(TOGETHER, " "), at, colour, _face(), size, 400)  # type: ignore[call-overload] # not in the stubs
    return at[0] + width_of(words, size)


def width_of(words: str, size: int) -> int:
    """Return how wide words are (px)."""
    box = cv2.getTextSize((4000, 4000), words.replace(TOGETHER, " "), (0, 0), _face(), size, 400)  # type: ignore[call-overload]
    return int(box[0] + box[2])


def _face() -> Any:
    if not _FACE:
        _FACE.append(cv2.FontFace("sans"))  # type: ignore[attr-defined]
    return _FACE[0]


class Chart:
    """A plot of `width` x `height` px that shows `box` (m). `scale` is that of lines and letters.

    `arm`: the path is that of the tool of an arm that stands at 0, 0.
    """

    def __init__(self, box: Box, width: int, height: int, scale: int = 1, arm: bool = False) -> None:
        self._box, self._scale, self._arm = box, scale, arm
        margin, high = MARGIN * scale, height - LEGEND * scale
        self._px = min((width - 2 * margin) / (box[2] - box[0]), (high - 2 * margin) / (box[3] - box[1]))  # px a m
        left = (width - self._px * (box[2] - box[0])) / 2
        top = (high - self._px * (box[3] - box[1])) / 2
        self._corner = left, top
        self._picture: Picture = np.full((height, width, 3), PAPER, np.uint8)
        self._last: Place | None = None  # of the path driven
        self._shown: set[str] = set()  # of what the legend names

    def at(self, place: Sequence[float]) -> tuple[int, int]:
        """Return the pixel of a place (m); y is up on the floor and down in the picture."""
        left, top = self._corner
        return round(left + self._px * (place[0] - self._box[0])), round(top + self._px * (self._box[3] - place[1]))

    def floor(self, floor: Floor | None) -> None:
        """Draw walls and things."""
        if floor is None:
            return
        for box in floor.rectangles:
            cv2.rectangle(self._picture, self.at(box[:2]), self.at(box[2:]), THING, -1)
            cv2.rectangle(self._picture, self.at(box[:2]), self.at(box[2:]), QUIET, self._scale)
        for x, y, radius in floor.circles:
            size = max(1, round(radius * self._px))
            cv2.circle(self._picture, self.at((x, y)), size, THING, -1, cv2.LINE_AA)
            cv2.circle(self._picture, self.at((x, y)), size, QUIET, self._scale, cv2.LINE_AA)
        cv2.rectangle(self._picture, self.at(floor.room[:2]), self.at(floor.room[2:]), WALL, 2 * self._scale)

    def draw_planned(self, line: Line) -> None:
        """Draw a path that is planned, in dashes."""
        self._shown.add("planned")
        for a, b in dashes([self.at(place) for place in line], DASH * self._scale, GAP * self._scale):
            cv2.line(self._picture, a, b, PLANNED, 5 * self._scale, cv2.LINE_AA)

    def draw_driven(self, place: Place) -> None:
        """Draw the next piece of the path driven; none where it jumps."""
        if self._last is not None and dist(self._last, place) < JUMP_M:
            cv2.line(self._picture, self.at(self._last), self.at(place), DRIVEN, 2 * self._scale, cv2.LINE_AA)
        self._last = place

    def with_marks(self, reading: PoseReading | None, taken: Iterable[tuple[int, Place]], marks: Marks) -> Picture:
        """Return the plot with the robot, what commands mark and pictures' numbers over it, and what its lines mean."""
        shown, scale = self._picture.copy(), self._scale
        for place in marks.work_places:
            self._shown.add("done")
            _diamond(shown, self.at(place), scale)
        for number, place in taken:
            self._shown.add("picture")
            x, y = self.at(place)
            cv2.circle(shown, (x, y), 4 * scale, TAKEN, -1, cv2.LINE_AA)
            x, y = x + BESIDE * scale, y - BESIDE * scale  # the robot that stands there hides no number
            cv2.circle(shown, (x, y), 8 * scale, TAKEN, -1, cv2.LINE_AA)
            size = (11 if number < 100 else 8) * scale
            text(shown, str(number), (x - width_of(str(number), size) // 2, y + size * 4 // 10), size, PAPER)
        if reading is not None and reading.arm:
            self._draw_arm(shown, [self.at(place) for place in reading.arm])
        elif reading is not None:
            self._robot(shown, reading.pose)
        if marks.target is not None:
            self._shown.add("target")
            _cross(shown, self.at(marks.target), scale)
        self._legend(shown, marks.label)
        return shown

    def _draw_arm(self, shown: Picture, points: Sequence[tuple[int, int]]) -> None:
        """Draw an arm's links, its base, its joints and its tool."""
        scale = self._scale
        for a, b in pairwise(points):
            cv2.line(shown, a, b, INK, 3 * scale, cv2.LINE_AA)
        for at, radius in ((points[0], 7), *((one, 4) for one in points[1:-1]), (points[-1], 6)):
            cv2.circle(shown, at, radius * scale, PAPER, -1, cv2.LINE_AA)
            cv2.circle(shown, at, (radius - 1) * scale, INK, -1, cv2.LINE_AA)

    def _robot(self, shown: Picture, pose: Sequence[float]) -> None:
        x, y = self.at(pose)
        size, heading = ROBOT * self._scale, pose[2]
        corners = ((size, 0.0), (0.8 * size, 2.5), (0.35 * size, 3.1416), (0.8 * size, -2.5))
        outline = [(x + r * cos(heading + turn), y - r * sin(heading + turn)) for r, turn in corners]
        points = np.round(outline).astype(np.int32)
        cv2.fillPoly(shown, [points], INK, cv2.LINE_AA)
        cv2.polylines(shown, [points], True, PAPER, self._scale, cv2.LINE_AA)

    def _legend(self, shown: Picture, done: str) -> None:
        """Write below the plot what is shown so far, in two rows where one is too short."""
        scale, size = self._scale, 13 * self._scale
        x, y = MARGIN * scale, shown.shape[0] - (8 + ROW) * scale
        named = {"driven": "moved" if self._arm else "driven", "done": done}
        for name in ("driven", *(one for one in ("planned", "target", "picture", "done") if one in self._shown)):
            words, wide = named.get(name, name), (24 if name in ("driven", "planned") else 14) * scale
            if x + wide + 5 * scale + width_of(words, size) > shown.shape[1]:
                x, y = MARGIN * scale, y + ROW * scale
            self._sign(shown, name, x, y - 4 * scale)
            x = text(shown, words, (x + wide + 5 * scale, y), size, INK) + 12 * scale

    def _sign(self, shown: Picture, name: str, x: int, y: int) -> None:
        scale = self._scale
        middle = x + 7 * scale, y
        if name == "driven":
            cv2.line(shown, (x, y), (x + 24 * scale, y), DRIVEN, 2 * scale, cv2.LINE_AA)
        elif name == "planned":
            for a, b in dashes([(x, y), (x + 24 * scale, y)], DASH * scale, GAP * scale):
                cv2.line(shown, a, b, PLANNED, 5 * scale, cv2.LINE_AA)
        elif name == "target":
            _cross(shown, middle, scale)
        elif name == "picture":
            cv2.circle(shown, middle, 7 * scale, TAKEN, -1, cv2.LINE_AA)
        else:
            _diamond(shown, middle, scale)


def _cross(shown: Picture, at: tuple[int, int], scale: int) -> None:
    """Draw a target: a ring with lines through it, of which a border of paper keeps it apart from what is below."""
    x, y = at
    for colour, wide in ((PAPER, 4), (TARGET, 2)):
        cv2.circle(shown, at, 7 * scale, colour, wide * scale, cv2.LINE_AA)
        for a, b in (((x - 10 * scale, y), (x + 10 * scale, y)), ((x, y - 10 * scale), (x, y + 10 * scale))):
            cv2.line(shown, a, b, colour, (wide - 1) * scale, cv2.LINE_AA)


def _diamond(shown: Picture, at: tuple[int, int], scale: int) -> None:
    size = WORK * scale
    corners = [(at[0] + size * cos(n * pi / 2), at[1] + size * sin(n * pi / 2)) for n in range(4)]
    points = np.round(corners).astype(np.int32)
    cv2.fillPoly(shown, [points], DONE, cv2.LINE_AA)
    cv2.polylines(shown, [points], True, INK, scale, cv2.LINE_AA)


def dashes(
    line: Sequence[tuple[int, int]], dash: int, gap: int
) -> list[tuple[tuple[int, int], tuple[int, int]]]:  # fmt: skip
    """Return the dashes along a line of pixels; they go on around its corners."""
    found, passed = [], 0.0
    for a, b in pairwise(line):
        length, at = dist(a, b), 0.0
        while at < length:
            phase = (passed + at) % (dash + gap)
            step = min(length - at, dash - phase if phase < dash else dash + gap - phase)
            step = max(step, 1e-3)
            if phase < dash:
                found.append((_along(a, b, at / length), _along(a, b, (at + step) / length)))
            at += step
        passed += length
    return found


def _along(a: tuple[int, int], b: tuple[int, int], share: float) -> tuple[int, int]:
    return round(a[0] + (b[0] - a[0]) * share), round(a[1] + (b[1] - a[1]) * share)
