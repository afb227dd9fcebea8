"""The path of a robot that rolls, or of an arm's tool, while it was recorded, and the paths planned. No Django."""

import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from math import nan
from pathlib import Path
from typing import Any

import msgspec

from robots.kit.contract.capabilities import Preview
from robots.kit.contract.find import spec_of
from robots.kit.previews import LENGTH, Job, read
from robots.kit.recording.container import STATE, Message
from robots.kit.recording.paths import (
    IN_PLANE,
    PREVIEWS,
    Line,
    Pose,
    PoseReading,
    Start,
    is_place,
    lines,
    placed,
    simplified,
)
from robots.kit.recording.reading import messages

MOST = 200_000  # poses of a recording: five hours of them
PREVIEW_S = 120.0  # to wait for all previews of a recording, at the lowest priority
Reader = Callable[[Message], PoseReading | None]


@dataclass(frozen=True)
class Track:
    """The path: poses with the time of each (ms since 1970), and each path that was planned, with its begin."""

    poses: tuple[tuple[int, Pose], ...] = ()
    plans: tuple[tuple[int, Line], ...] = ()

    def driven(self) -> list[Line]:
        """Return the path driven, in pieces where it jumps."""
        return lines(pose for _, pose in self.poses)

    def plot_paths(self) -> dict[str, list[Line]]:
        """Return it for a page: at most some hundred points of each."""
        return {"driven": simplified(self.driven()), "planned": simplified([line for _, line in self.plans])}


def pose_of(message: Message) -> Pose | None:
    """Return where a state says that the robot is, None where it does not."""
    try:
        values = message.content().get("values")
        told = values if isinstance(values, Mapping) else {}
        x, y, heading = (nan if told.get(name) is None else float(told[name]) for name in IN_PLANE)
    except (ValueError, TypeError):
        return None
    return (x, y, heading) if is_place((x, y, heading)) else None


def reader_of(plot: Mapping[str, Any]) -> Reader:
    """Return what reads the states of a recording. `plot`: the result of `plots.plot_of`."""
    if plot.get("of_tool"):
        from robots.kit.recording.arm import tool_of  # noqa: PLC0415 - not every robot is an arm

        return tool_of(plot["driver"])
    return lambda message: PoseReading(pose, pose) if (pose := pose_of(message)) is not None else None


def poses_in(path: Path, read: Reader) -> Iterator[tuple[int, Pose, Start]]:
    """Yield what `read` finds in a recording, after the time of each (ms since 1970). Raises OSError."""
    for count, message in enumerate(messages(path, {STATE})):
        if count >= MOST:
            return
        if (found := read(message)) is not None:
            yield message.at_ns // 10**6, found.pose, found.start


def track_of(path: Path, plot: Mapping[str, Any]) -> Track:
    """Return the track of a recording. `plot`: the result of `plots.plot_of`. Raises OSError."""
    found = tuple(poses_in(path, reader_of(plot)))
    starts = [(at, start) for at, _, start in found]
    return Track(tuple((at, pose) for at, pose, _ in found), tuple(_planned(plot, starts)))


def _planned(plot: Mapping[str, Any], starts: Sequence[tuple[int, Start]]) -> Iterator[tuple[int, Line]]:
    """Yield the path that each command was to take, from where the robot was when it began."""
    begun = [(one, _start(starts, one["at_ms"])) for one in plot["commands"][:PREVIEWS]] if starts else []
    if not begun or not _foresees(plot["driver"]):
        return
    jobs = [Job(plot["driver"], plot["settings"], one["kind"], one["args"], start) for one, start in begun]
    for (one, start), answer in zip(begun, previews(jobs), strict=False):
        tool = answer.get("tool") or () if plot.get("of_tool") else ()
        line = [(place[0], place[1]) for place in tool if is_place(place)] or placed(answer.get("poses") or (), start)
        if len(line) > 1:
            yield one["at_ms"], line


def _start(starts: Sequence[tuple[int, Start]], at_ms: int) -> Start:
    before = [start for at, start in starts if at <= at_ms]
    return before[-1] if before else starts[0][1]


def _foresees(driver: str) -> bool:
    try:
        return spec_of(driver).capability(Preview) is not None
    except LookupError:
        return False


def previews(jobs: Sequence[Job]) -> Iterator[dict[str, Any]]:
    """Yield the previews of a process of its own, which has its own limits; unanswered jobs are left out."""
    bodies = [msgspec.msgpack.encode(job) for job in jobs]
    asked = b"".join(LENGTH.pack(len(body)) + body for body in bodies)
    argv = [sys.executable, "-m", "robots.kit.previews"]
    try:
        done = subprocess.run(  # noqa: S603 - our own module
            argv, input=asked, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, timeout=PREVIEW_S, check=False
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired):
        return
    said = BytesIO(done.stdout)
    while (body := read(said)) is not None:
        yield msgspec.json.decode(body)
