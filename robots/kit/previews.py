"""Computes where a command would lead, in a process of its own: `python -m robots.kit.previews`.

Jobs come on standard input, answers go to standard output, each as four bytes of length and a body. A job has limits
of processor time and memory; one that exceeds them ends this process, not the one that asked. No Django, no robot
connection, no secrets.
"""

import os
import resource
import signal
import struct
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO

import msgspec

from robots.kit.contract.capabilities import Foreseen, Preview
from robots.kit.contract.errors import BadRequest, RobotError
from robots.kit.contract.find import function, spec_of

CPU_S = 1.0  # for one job; many times what our own drivers need
MEMORY = 256 * 2**20  # bytes more than before the job
LARGEST = 2**20  # bytes of an answer
JUDGEMENTS = 100  # of the steps of a program
POSES, FARTHEST = 2000, 1e6  # of a path in the robot's own frame: how many; m, rad and s of each
LENGTH = struct.Struct("<I")
TOO_MUCH = "This is too long to compute in advance; choose a nearer target or a shorter program."


class Job(msgspec.Struct, frozen=True):
    """A command that is only tried: robot, command, and the joints from which it starts (rad, m), if it has any.

    `packets` are those of the byte stream that its `Preview` names.
    """

    driver: str
    settings: dict[str, Any]
    kind: str
    args: dict[str, Any]
    joints: tuple[float, ...]
    n: int = 0
    packets: tuple[tuple[bytes, bool], ...] = ()


_DECODER = msgspec.msgpack.Decoder(Job)
_JSON = msgspec.json.Encoder(enc_hook=float)  # drivers return numpy's floats


def compute(job: Job) -> dict[str, Any]:
    """Return where the command would lead, or why it cannot be done."""
    try:
        spec = spec_of(job.driver)
        offered = spec.capability(Preview)
        if offered is None:
            raise BadRequest("This robot cannot say where a command would lead.")
        more = (job.packets,) if offered.stream else ()
        found = function(offered.function)(job.kind, job.args, job.joints, job.settings, *more)
    except RobotError as error:
        return {"ok": False, "text": str(error)}
    judged = found.judgements[:JUDGEMENTS]
    refusal = next((one.text for one in judged if one.refuses), "")
    return {
        "ok": not refusal, "text": refusal, "joints": found.joints, "seconds": round(found.seconds, 2),
        "tool": [[round(v, 4) for v in place] for place in found.tool],
        "path": [[round(v, 4) for v in q] for q in found.path], "steps": found.steps,
        "judgements": [{**asdict(one), "at_s": round(one.at_s, 2)} for one in judged],
        **rolled(found, len(spec.pose.coordinates) if spec.pose else 0),
    }  # fmt: skip


def rolled(preview: Foreseen, coordinates: int) -> dict[str, Any]:
    """Return the poses in the robot's own frame and their times (s), each pose with so many coordinates.

    Raises ValueError where a driver tells what is no such path.
    """
    poses, times = [[float(v) for v in pose] for pose in preview.poses], [float(t) for t in preview.times]
    if len(poses) != len(times) or len(poses) > POSES or any(len(pose) != coordinates for pose in poses):
        raise ValueError(f"a path has at most {POSES} poses of {coordinates} coordinates, and a time for each")
    if not all(abs(v) < FARTHEST for v in (*times, *chain(*poses))) or times != sorted([0.0, *times])[1:]:
        raise ValueError("the poses and times of a path are finite, and its times do not fall")
    return {"poses": [[round(v, 4) for v in pose] for pose in poses], "times": [round(t, 3) for t in times]}


def prepare(job: Job) -> None:
    """Load the modules and data of the robot, outside the limits. Raises LookupError."""
    offered = spec_of(job.driver).capability(Preview)
    if offered is not None:
        function(offered.function)
        if offered.prepare:
            function(offered.prepare)(job.settings)


@contextmanager
def bounds() -> Iterator[None]:
    """Limit this process: above its processor time the kernel ends it, above its memory allocation fails."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MEMORY, hard))
    signal.setitimer(signal.ITIMER_PROF, CPU_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))


def answer(body: bytes) -> bytes:
    """Return the message for the page as JSON. Limits this process meanwhile, so call it in a process of its own."""
    job = _DECODER.decode(body)
    try:
        prepare(job)
        with bounds():
            said = _JSON.encode({"t": "plan", "n": job.n, **compute(job)})
    except (ArithmeticError, LookupError, MemoryError, TypeError, ValueError) as error:  # not a reason to end
        sys.stderr.write(f"a preview failed: {type(error).__name__}: {error}\n")
        said = msgspec.json.encode({"t": "plan", "n": job.n, "ok": False, "text": TOO_MUCH})
    if len(said) > LARGEST:
        said = msgspec.json.encode({"t": "plan", "n": job.n, "ok": False, "text": TOO_MUCH})
    return said


def read(source: BinaryIO) -> bytes | None:
    """Return the next body; None at the end."""
    head = source.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    (length,) = LENGTH.unpack(head)
    body = source.read(length)
    return body if len(body) == length else None


def _warm(body: bytes) -> None:
    with suppress(LookupError):
        prepare(_DECODER.decode(body))


def main() -> None:
    """Answer jobs until standard input ends, at low priority."""
    if (body := read(sys.stdin.buffer)) is not None:
        _warm(body)  # at normal priority, because somebody waits for it
    os.nice(10)
    while body is not None:
        said = answer(body)
        sys.stdout.buffer.write(LENGTH.pack(len(said)) + said)
        sys.stdout.buffer.flush()
        body = read(sys.stdin.buffer)


if __name__ == "__main__":
    main()
