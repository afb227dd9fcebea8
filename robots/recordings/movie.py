"""Makes a movie of recordings: H.264 in MP4, or VP9 in WebM. A process of its own, because it computes for long.

    python -m robots.recordings.movie KIND OUT NICENESS < plan.json

The plan: pictures a second, whether the pictures come `every_s` seconds (of a time-lapse, which shows the first
camera) or as they were taken (by all cameras, side by side), and files with their times (ms since 1970): recordings, or
single JPEGs. What of a file cannot be read is left out. It prints how far it is, in percent, and at last of how many
pictures the movie is. It ends by itself at its limits. No Django.
"""

import contextlib
import json
import math
import os
import resource
import sys
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from robots.recordings.axis import Axis
from robots.recordings.container import camera_of, jpeg_of
from robots.recordings.reading import messages, parts

CODECS = {"mp4": ("libx264", {"preset": "veryfast", "crf": "24"}),
          "webm": ("libvpx-vp9", {"deadline": "realtime", "cpu-used": "8", "crf": "34", "b": "0"})}  # fmt: skip
TICKS = 1000  # a second of a movie, for pictures that come as they were taken
MEMORY = 2_000_000_000  # bytes
LARGEST = 400_000_000  # bytes of a movie
CPU_S = 280
MOST = 30_000  # pictures
NEXT_MS = 20  # between two pictures of a movie at least; of several cameras some come together
HOLD_MS = 5000  # a picture stays no longer, where the next one came later


class Sheet:
    """The last picture of each camera side by side, in cells of the size of the first picture that came."""

    def __init__(self, cameras: Sequence[int]) -> None:
        columns = max(1, math.ceil(math.sqrt(len(cameras))))
        self._cell_of = {camera: divmod(n, columns) for n, camera in enumerate(cameras)}
        self._shape = math.ceil(len(cameras) / columns), columns
        self._cell = (0, 0)  # height, width in pixels
        self._sheet: Any = None

    def with_picture(self, camera: int, picture: Any) -> Any:
        """Return the sheet (an av.VideoFrame) with this picture (another) in its cell, whole, in the middle."""
        from av import VideoFrame  # noqa: PLC0415 - only here

        if self._sheet is None:
            self._cell = picture.height // 2 * 2, picture.width // 2 * 2
            self._sheet = np.zeros((self._shape[0] * self._cell[0], self._shape[1] * self._cell[1], 3), np.uint8)
        share = min(self._cell[0] / picture.height, self._cell[1] / picture.width)
        height, width = (max(1, round(share * pixels)) for pixels in (picture.height, picture.width))
        row, column = self._cell_of[camera]
        top = row * self._cell[0] + (self._cell[0] - height) // 2
        left = column * self._cell[1] + (self._cell[1] - width) // 2
        self._sheet[top : top + height, left : left + width] = picture.reformat(width, height, "rgb24").to_ndarray()
        return VideoFrame.from_ndarray(self._sheet, "rgb24")


def cameras_of(plan: dict[str, Any]) -> list[int]:
    """Return the cameras that the movie shows. Raises OSError, ValueError."""
    if plan.get("every_s"):
        return [0]
    found = {camera_of(one.topic) for name, _ in plan["files"] for one in messages(Path(name))}
    return sorted(camera for camera in found if camera is not None)


def _of_file(path: Path, began_ms: int, cameras: Sequence[int]) -> Iterator[tuple[float, int, int, bytes]]:
    """Yield for each picture of these cameras how far the file is read, when it arrived (ms), its camera, its JPEG."""
    if path.suffix == ".jpg":
        yield 1.0, began_ms, 0, path.read_bytes()
        return
    axis, size = Axis(), path.stat().st_size
    for part in parts(path):
        for message in part.messages:
            at_ms, camera = began_ms + axis.place(message.at_ns) // 10**6, camera_of(message.topic)
            if camera is None or camera not in cameras:
                continue
            with contextlib.suppress(ValueError):
                yield part.offset / size, at_ms, camera, jpeg_of(message.told())


def chosen(
    plan: dict[str, Any], cameras: Sequence[int], tell: Callable[[float], None] = lambda _: None
) -> Iterator[tuple[int, int, bytes]]:
    """Yield the time of each picture in the movie (ms), never earlier than the one before, its camera, and its JPEG.

    `tell` is given how far the files are read, from 0 to 1.
    """
    every_ms, begun, last, at = int(1000 * plan.get("every_s", 0)), False, -(10**15), 0
    for number, (name, began_ms) in enumerate(plan["files"]):
        if not name.endswith(".jpg"):
            last = min(last, began_ms - every_ms)  # the time of day may have been set back since the file before
        for read, taken, camera, jpeg in _of_file(Path(name), began_ms, cameras):
            tell((number + read) / len(plan["files"]))
            if every_ms and taken - last < every_ms:
                continue
            if begun:
                at += int(1000 / plan["hz"]) if every_ms else min(HOLD_MS, max(0, taken - last))
            last, begun = max(taken, last), True
            yield at, camera, jpeg


class Told:
    """Prints how far it is, each percent once."""

    def __init__(self) -> None:
        self._percent = 0

    def __call__(self, share: float) -> None:
        """Take a share from 0 to 1."""
        if int(100 * share) > self._percent:
            self._percent = int(100 * share)
            sys.stdout.write(f"{self._percent} %\n")
            sys.stdout.flush()


def make(kind: str, out: Path, plan: dict[str, Any]) -> int:
    """Write the movie. Return of how many pictures. Raises OSError, ValueError, av.FFmpegError."""
    import av  # noqa: PLC0415 - only here

    codec, options = CODECS[kind]
    count, shown_at = 0, -NEXT_MS
    cameras = cameras_of(plan)
    with av.open(str(out), "w", format=kind, options={"movflags": "+faststart"} if kind == "mp4" else {}) as movie:
        stream: Any = None
        sheet = Sheet(cameras)
        decoder: Any = av.CodecContext.create("mjpeg", "r")
        for at, camera, jpeg in chosen(plan, cameras, Told()):
            try:
                pictures = decoder.decode(av.Packet(jpeg))
            except av.FFmpegError:
                continue  # one picture that is broken ends no movie
            for picture in pictures:
                together = sheet.with_picture(camera, picture)
                if at < shown_at + NEXT_MS:
                    continue  # it comes with the next one
                if stream is None:
                    stream = movie.add_stream(codec, rate=25, options=options)
                    stream.width, stream.height = together.width, together.height
                    stream.pix_fmt = "yuv420p"
                    stream.codec_context.time_base = Fraction(1, TICKS)
                    stream.codec_context.thread_count = 1
                shown = together.reformat(format="yuv420p")
                shown.pts, shown.time_base = at, Fraction(1, TICKS)
                movie.mux(stream.encode(shown))
                count, shown_at = count + 1, at
            if count >= MOST:
                break
        if stream is not None:
            movie.mux(stream.encode())
    return count


def main() -> None:
    """Make what standard input asks for; print of how many pictures."""
    kind, out, nice = sys.argv[1:]
    os.nice(int(nice))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S))
    resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST, LARGEST))
    count = make(kind, Path(out), json.load(sys.stdin))
    sys.stdout.write(f"{count}\n")


if __name__ == "__main__":
    main()
