"""The path of a robot that rolls while it was recorded, and the paths that were planned. No Django."""

import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
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
from robots.kit.recording.paths import IN_PLANE, PREVIEWS, Line, is_place, lines, placed, simplified
from robots.kit.recording.reading import messages

MOST = 200_000  # poses of a recording: five hours of them
PREVIEW_S = 120.0  # to wait for all previews of a recording, at the lowest priority
Pose = tuple[float, float, float]


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


def poses_in(path: Path) -> Iterator[tuple[int, Pose]]:
    """Yield the poses of a recording with the time of each (ms since 1970). Raises OSError."""
    for count, message in enumerate(messages(path, {STATE})):
        if count >= MOST:
            return
        if (pose := pose_of(message)) is not None:
            yield message.at_ns // 10**6, pose


def track_of(path: Path, plot: Mapping[str, Any]) -> Track:
    """Return the track of a recording. `plot`: the result of `plots.plot_of`. Raises OSError."""
    poses = tuple(poses_in(path))
    return Track(poses, tuple(_planned(plot, poses)))


def _planned(plot: Mapping[str, Any], poses: Sequence[tuple[int, Pose]]) -> Iterator[tuple[int, Line]]:
    """Yield the path that each command was to take, from where the robot was when it began."""
    begun = [(one, _start(poses, one["at_ms"])) for one in plot["commands"][:PREVIEWS]] if poses else []
    if not begun or not _foresees(plot["driver"]):
        return
    jobs = [Job(plot["driver"], plot["settings"], one["kind"], one["args"], start) for one, start in begun]
    for (one, start), answer in zip(begun, previews(jobs), strict=False):
        line = placed(answer.get("poses") or (), start)
        if len(line) > 1:
            yield one["at_ms"], line


def _start(poses: Sequence[tuple[int, Pose]], at_ms: int) -> Pose:
    before = [pose for at, pose in poses if at <= at_ms]
    return before[-1] if before else poses[0][1]


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
