"""Makes a movie of recordings: H.264 in MP4, or VP9 in WebM. A process of its own, because it computes for long.

    python -m robots.recordings.movie KIND OUT < plan.json

The plan: pictures a second, whether the pictures come `every_s` seconds (of a time-lapse) or as they were taken, and
files: recordings, or single JPEGs. It runs with the lowest priority and ends by itself at its limits. No Django.
"""

import json
import os
import resource
import sys
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

from robots.recordings.container import CAMERA, jpeg_of, messages, taken_ms

CODECS = {"mp4": ("libx264", {"preset": "veryfast", "crf": "24"}),
          "webm": ("libvpx-vp9", {"deadline": "realtime", "cpu-used": "8", "crf": "34", "b": "0"})}  # fmt: skip
TICKS = 1000  # a second of a movie, for pictures that come as they were taken
MEMORY = 2_000_000_000  # bytes
LARGEST = 400_000_000  # bytes of a movie
CPU_S = 280
MOST = 30_000  # pictures
HOLD_MS = 5000  # a picture stays no longer, where the next one came later


def _of_file(path: Path) -> Iterator[tuple[int, bytes]]:
    """Yield when each picture of the first camera was taken (ms), and its JPEG."""
    if path.suffix == ".jpg":
        yield int(path.stat().st_mtime * 1000), path.read_bytes()
        return
    for message in messages(path, [f"{CAMERA}0"]):
        told = message.told()
        yield taken_ms(told), jpeg_of(told)


def chosen(plan: dict[str, Any]) -> Iterator[tuple[int, bytes]]:
    """Yield the time of each picture in the movie (ms), and its JPEG."""
    every_ms, shown, last, at = int(1000 * plan.get("every_s", 0)), 0, -(10**15), 0
    for name in plan["files"]:
        for taken, jpeg in _of_file(Path(name)):
            if taken <= last or (every_ms and taken - last < every_ms):
                continue
            at += int(1000 / plan["hz"]) if every_ms else min(HOLD_MS, taken - last) if shown else 0
            last = taken
            yield at, jpeg
            shown += 1
            if shown >= MOST:
                return


def make(kind: str, out: Path, plan: dict[str, Any]) -> int:
    """Write the movie. Return of how many pictures. Raises OSError, ValueError, av.FFmpegError."""
    import av  # noqa: PLC0415 - only here

    codec, options = CODECS[kind]
    count = 0
    with av.open(str(out), "w", format=kind, options={"movflags": "+faststart"} if kind == "mp4" else {}) as movie:
        stream: Any = None
        decoder: Any = av.CodecContext.create("mjpeg", "r")
        for at, jpeg in chosen(plan):
            try:
                pictures = decoder.decode(av.Packet(jpeg))
            except av.FFmpegError:
                continue  # one picture that is broken ends no movie
            for picture in pictures:
                if stream is None:
                    stream = movie.add_stream(codec, rate=25, options=options)
                    stream.width, stream.height = picture.width // 2 * 2, picture.height // 2 * 2
                    stream.pix_fmt = "yuv420p"
                    stream.codec_context.time_base = Fraction(1, TICKS)
                    stream.codec_context.thread_count = 1
                shown = picture.reformat(stream.width, stream.height, "yuv420p")
                shown.pts, shown.time_base = at, Fraction(1, TICKS)
                movie.mux(stream.encode(shown))
                count += 1
        if stream is not None:
            movie.mux(stream.encode())
    return count


def main() -> None:
    """Make what standard input asks for; print of how many pictures."""
    os.nice(19)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S))
    resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST, LARGEST))
    kind, out = sys.argv[1:]
    count = make(kind, Path(out), json.load(sys.stdin))
    sys.stdout.write(f"{count}\n")


if __name__ == "__main__":
    main()
