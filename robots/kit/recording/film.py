"""A movie's picture with the plot of the robot's path beside it and captions above: 640 x 360 px, or twice that.

No Django.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import cv2
import numpy as np

from robots.kit.contract.floor import Floor
from robots.kit.recording.captions import Captions, wrapped
from robots.kit.recording.chart import Chart, Picture, text, width_of
from robots.kit.recording.container import COMMANDS, STATE, Message
from robots.kit.recording.marks import Marks
from robots.kit.recording.paths import PoseReading, plot_bounds
from robots.kit.recording.track import Track, reader_of

WIDTH, HEIGHT = 640, 360
VIEW = 352, 264  # the picture's part, lower left; the plot is to its right
TOP = HEIGHT - VIEW[1]  # the captions' part: above, because the controls of a player cover what is below
GROUND, WORDS, QUIET = (24, 24, 24), (255, 255, 255), (190, 190, 190)
LETTERS, LINE, LINES = 15, 21, 3  # px of the captions; how many there are below the time
FOLLOWED = (STATE, COMMANDS)


class Film:
    """Follows a recording message by message. `plot`: the result of `plots.plot_of`."""

    def __init__(self, plot: Mapping[str, Any], track: Track, floor: Floor | None) -> None:
        self._track, self._floor, self._plot = track, floor, plot
        notes = [(one["at_ms"], one["text"]) for one in plot["findings"]]
        self._captions = Captions(notes, plot["labels"])
        self._taken = [(f["at_ms"], f["number"], tuple(f["place"])) for f in plot["findings"] if f["place"]]
        self._planned = list(track.plans)
        self._read = reader_of(plot)
        self._marks = Marks(plot.get("works"))
        self._reading: PoseReading | None = None
        self._now_ms = 0
        self._chart: Chart | None = None
        self._waits: list[PoseReading] = []  # of the path driven, not yet drawn
        self._scale = 1

    def follow(self, message: Message) -> None:
        """Take a message of the recording."""
        self._now_ms = message.at_ns // 10**6
        if message.topic == COMMANDS:
            self._captions.take(message)
            self._marks.take(message)
        elif message.topic == STATE and (found := self._read(message)) is not None:
            self._reading = found
            self._waits.append(found)

    def beside(self, picture: Picture) -> Picture:
        """Return a picture with plot and captions as they are now; all of one film have one size."""
        chart = self._chart or self._begun(picture)
        while self._planned and self._planned[0][0] <= self._now_ms:
            chart.draw_planned(self._planned.pop(0)[1])
        for reading in self._waits:
            chart.draw_driven(reading.pose[:2])
        self._waits.clear()
        scale = self._scale
        width, top = VIEW[0] * scale, TOP * scale
        frame = np.full((HEIGHT * scale, WIDTH * scale, 3), GROUND, np.uint8)
        _fit(frame[top:, :width], picture)
        taken = [(number, place) for at, number, place in self._taken if at <= self._now_ms]
        frame[top:, width:] = chart.with_marks(self._reading, taken, self._marks)
        self._write(frame)
        return frame

    def _begun(self, picture: Picture) -> Chart:
        self._scale = 2 if picture.shape[1] > 1.5 * VIEW[0] else 1
        path = [*self._track.driven(), *(line for _, line in self._track.plans)]
        size = (WIDTH - VIEW[0]) * self._scale, VIEW[1] * self._scale
        floor, arm = self._floor, bool(self._plot.get("of_tool"))
        if arm:
            path.append([(0.0, 0.0)])  # its base
        if self._plot.get("near"):
            path += [[box[:2], box[2:]] for box in (floor.rectangles if floor else ())]
            floor = None
        self._chart = Chart(plot_bounds(floor, path), *size, self._scale, arm)
        self._chart.floor(self._floor)
        return self._chart

    def _write(self, frame: Picture) -> None:
        scale = self._scale
        time, step, read = self._captions.at(self._now_ms)
        size, x, y = LETTERS * scale, 10 * scale, 20 * scale
        begin = text(frame, time, (x, y), size, QUIET) + 16 * scale
        words = str(self._plot["name"])
        if begin + width_of(words, size) < frame.shape[1]:
            text(frame, words, (frame.shape[1] - 10 * scale - width_of(words, size), y), size, QUIET)
        room = frame.shape[1] - 2 * x
        steps = fitting(step, size, room, 2)
        reads = fitting(read, size, room, LINES - len(steps))
        for line, colour in [*((one, WORDS) for one in steps), *((one, QUIET) for one in reads)]:
            y += LINE * scale
            text(frame, line, (x, y), size, colour)


def _fit(view: Picture, picture: Picture) -> None:
    """Put a picture whole into the middle of a view."""
    height, width = view.shape[:2]
    share = min(height / picture.shape[0], width / picture.shape[1])
    h, w = max(1, round(share * picture.shape[0])), max(1, round(share * picture.shape[1]))
    how = cv2.INTER_AREA if share < 1 else cv2.INTER_LINEAR
    top, left = (height - h) // 2, (width - w) // 2
    view[top : top + h, left : left + w] = cv2.resize(picture, (w, h), interpolation=how)


@lru_cache(16)
def fitting(words: str, size: int, room: int, most: int) -> list[str]:
    """Return the words in at most so many lines, each at most so wide (px)."""
    fits = len(words) * room // max(1, width_of(words, size))
    while (found := wrapped(words, max(2, fits), most)) and max(width_of(line, size) for line in found) > room:
        if fits <= 2:
            return []
        fits -= 1
    return found
