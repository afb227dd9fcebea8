"""Makes a movie of recordings: H.264 in MP4, or VP9 in WebM. A process of its own, because it computes for long.

    python -m robots.kit.recording.movie KIND OUT NICENESS < plan.json

The plan has the pictures a second; whether the pictures come every `every_s` seconds (in a time-lapse, which shows the
first camera) or as they were taken (by all cameras, side by side); and files with their times (ms since 1970), which
are recordings or single JPEGs. With a `plot` the robot's path is shown beside the pictures. A part of a file that
cannot be read is left out. The process prints the path as JSON, its progress in percent, and at the end the number of
pictures in the movie. It ends by itself at its limits. MP4 is written in fragments, each of which begins with a key
frame. No Django.
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

from robots.kit.recording.axis import Axis
from robots.kit.recording.container import Message, camera_of, jpeg_of
from robots.kit.recording.film import FOLLOWED, Film
from robots.kit.recording.floors import floor_of
from robots.kit.recording.reading import messages, parts
from robots.kit.recording.track import track_of

# pictures that refer to later ones would delay the first of a file in fragments
CODECS = {"mp4": ("libx264", {"preset": "veryfast", "crf": "24", "bf": "0", "g": "25"}),
          "webm": ("libvpx-vp9", {"deadline": "realtime", "cpu-used": "8", "crf": "34", "b": "0"})}  # fmt: skip
FRAGMENTS = {"mp4": {"movflags": "frag_keyframe+empty_moov+default_base_moof+global_sidx"}}
TICKS = 1000  # a second of a movie, for pictures that come as they were taken
MEMORY = 2_000_000_000  # bytes
LARGEST = 400_000_000  # bytes of a movie
CPU_S = 280
MOST = 30_000  # pictures
NEXT_MS = 20  # between two pictures of a movie at least; of several cameras some come together
HOLD_MS = 5000  # the longest time that a picture stays
PLOT_MS = 400  # without a picture for so long, the plot is drawn anew beside the last one


class Sheet:
    """The last picture of each camera side by side, in cells of the size of the first picture that came."""

    def __init__(self, cameras: Sequence[int]) -> None:
        columns = max(1, math.ceil(math.sqrt(len(cameras))))
        self._cell_of = {camera: divmod(n, columns) for n, camera in enumerate(cameras)}
        self._shape = math.ceil(len(cameras) / columns), columns
        self._cell = (0, 0)  # height, width in pixels
        self._sheet: Any = None

    def with_picture(self, camera: int, picture: Any) -> Any:
        """Return the sheet (RGB) with this picture (an av.VideoFrame) in its cell, whole, in the middle."""
        if self._sheet is None:
            self._cell = picture.height // 2 * 2, picture.width // 2 * 2
            self._sheet = np.zeros((self._shape[0] * self._cell[0], self._shape[1] * self._cell[1], 3), np.uint8)
        share = min(self._cell[0] / picture.height, self._cell[1] / picture.width)
        height, width = (max(1, round(share * pixels)) for pixels in (picture.height, picture.width))
        row, column = self._cell_of[camera]
        top = row * self._cell[0] + (self._cell[0] - height) // 2
        left = column * self._cell[1] + (self._cell[1] - width) // 2
        self._sheet[top : top + height, left : left + width] = picture.reformat(width, height, "rgb24").to_ndarray()
        return self._sheet


def cameras_of(plan: dict[str, Any]) -> list[int]:
    """Return the cameras that the movie shows. Raises OSError, ValueError."""
    if plan.get("every_s"):
        return [0]
    found = {camera_of(one.topic) for name, _ in plan["files"] for one in messages(Path(name))}
    return sorted(camera for camera in found if camera is not None)


def _of_file(
    path: Path, began_ms: int, cameras: Sequence[int], follow: Callable[[Message], None] | None
) -> Iterator[tuple[float, int, int, bytes]]:
    """Yield for each picture of these cameras how far the file is read, when it arrived (ms), its camera, its JPEG.

    `follow` gets each message; with it also the moments of followed messages between two pictures are yielded, without
    a JPEG.
    """
    if path.suffix == ".jpg":
        yield 1.0, began_ms, 0, path.read_bytes()
        return
    axis, size = Axis(), path.stat().st_size
    for part in parts(path):
        for message in part.messages:
            at_ms, camera = began_ms + axis.place(message.at_ns) // 10**6, camera_of(message.topic)
            if follow is not None:
                follow(message)
                if message.topic in FOLLOWED:
                    yield part.offset / size, at_ms, -1, b""
            if camera is None or camera not in cameras:
                continue
            with contextlib.suppress(ValueError):
                yield part.offset / size, at_ms, camera, jpeg_of(message.content())


def chosen_pictures(
    plan: dict[str, Any], cameras: Sequence[int], tell: Callable[[float], None] = lambda _: None,
    follow: Callable[[Message], None] | None = None,
) -> Iterator[tuple[int, int, bytes]]:  # fmt: skip
    """Yield the time of each picture in the movie (ms), never earlier than the one before, its camera, and its JPEG.

    `tell` gets the share of the files that is read; `follow` gets each message before the picture that follows it. With
    it late pictures are preceded by moments without one.
    """
    every_ms, begun, last, at = int(1000 * plan.get("every_s", 0)), False, -(10**15), 0
    for number, (name, began_ms) in enumerate(plan["files"]):
        if not name.endswith(".jpg"):
            last = min(last, began_ms - every_ms)  # the time of day may have been set back since the file before
        for read, taken, camera, jpeg in _of_file(Path(name), began_ms, cameras, follow):
            tell((number + read) / len(plan["files"]))
            if every_ms and taken - last < every_ms:
                continue
            if not jpeg and (not begun or taken - last < PLOT_MS):
                continue
            if begun:
                at += int(1000 / plan["hz"]) if every_ms else min(HOLD_MS, max(0, taken - last))
            last, begun = max(taken, last), True
            yield at, camera, jpeg


class ProgressPrinter:
    """Prints the progress, each percent once."""

    def __init__(self) -> None:
        self._percent = 0

    def __call__(self, share: float) -> None:
        """Take a share from 0 to 1."""
        if int(100 * share) > self._percent:
            self._percent = int(100 * share)
            sys.stdout.write(f"{self._percent} %\n")
            sys.stdout.flush()


class Writer:
    """Encodes pictures (red, green, blue) of one size into a movie."""

    def __init__(self, movie: Any, kind: str) -> None:
        self._movie, self._codec = movie, CODECS[kind]
        self._stream: Any = None
        self.count, self._shown_at = 0, -NEXT_MS

    def put(self, picture: Any, at: int) -> None:
        """Show a picture from a time on (ms), unless it comes with the next one. Raises av.FFmpegError, OSError."""
        from av import VideoFrame  # noqa: PLC0415 - only here

        if at < self._shown_at + NEXT_MS:
            return
        if self._stream is None:
            codec, options = self._codec
            self._stream = self._movie.add_stream(codec, rate=25, options=options)
            self._stream.height, self._stream.width = picture.shape[:2]
            self._stream.pix_fmt = "yuv420p"
            self._stream.codec_context.time_base = Fraction(1, TICKS)
            self._stream.codec_context.thread_count = 1
        shown = VideoFrame.from_ndarray(picture, "rgb24").reformat(format="yuv420p")
        shown.pts, shown.time_base = at, Fraction(1, TICKS)
        self._movie.mux(self._stream.encode(shown))
        self.count, self._shown_at = self.count + 1, at

    def end(self) -> None:
        """Write what the encoder still has. Raises av.FFmpegError, OSError."""
        if self._stream is not None:
            self._movie.mux(self._stream.encode())


def _film(plan: dict[str, Any]) -> Film | None:
    """Return the film that shows the robot's path beside the pictures, and print the path; None without a path."""
    plot = plan.get("plot")
    if not plot:
        return None
    track = track_of(Path(plan["files"][0][0]), plot)
    sys.stdout.write(json.dumps(track.plot_paths()) + "\n")
    sys.stdout.flush()
    return Film(plot, track, floor_of(plot["driver"], plot["settings"])) if track.poses else None


def make(kind: str, out: Path, plan: dict[str, Any]) -> int:
    """Write the movie; return the number of its pictures. Raises OSError, ValueError, av.FFmpegError."""
    import av  # noqa: PLC0415 - only here

    cameras, film = cameras_of(plan), _film(plan)
    with av.open(str(out), "w", format=kind, options=FRAGMENTS.get(kind, {})) as movie:
        writer, sheet, together, last_ms = Writer(movie, kind), Sheet(cameras), None, 0
        decoder: Any = av.CodecContext.create("mjpeg", "r")
        for at, camera, jpeg in chosen_pictures(plan, cameras, ProgressPrinter(), film.follow if film else None):
            if jpeg:
                try:
                    for picture in decoder.decode(av.Packet(jpeg)):
                        together = sheet.with_picture(camera, picture)
                except (av.FFmpegError, ValueError):
                    continue  # one picture that is broken ends no movie
            if together is not None:
                writer.put(film.beside(together) if film else together, at)
            last_ms = at
            if writer.count >= MOST:
                break
        if film is not None and together is not None:  # how it ended came after the last picture
            for late_ms in (PLOT_MS, PLOT_MS + 1000):
                writer.put(film.beside(together), last_ms + late_ms)
        writer.end()
    if writer.count and not whole(out, writer.count):
        raise OSError("the movie could not be written to its end")
    return writer.count


def whole(out: Path, count: int) -> bool:
    """Tell whether a movie has so many pictures: libraries do not report what a full disk refused at the end."""
    import av  # noqa: PLC0415 - only here

    try:
        with av.open(str(out)) as movie:
            sound = sum(packet.size > 0 and not packet.is_corrupt for packet in movie.demux(video=0))
    except (av.FFmpegError, OSError):
        return False
    return sound == count


def main() -> None:
    """Make the movie of the plan on standard input; print the number of its pictures."""
    kind, out, nice = sys.argv[1:]
    os.nice(int(nice))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S))
    resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST, LARGEST))
    count = make(kind, Path(out), json.load(sys.stdin))
    sys.stdout.write(f"{count}\n")


if __name__ == "__main__":
    main()
