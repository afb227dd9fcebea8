"""The movie of the day for sixty who join within its two minutes: bytes of the origin beside unicast and the least.

A movie of 120 s, pictures of even size (500 kbit/s); everybody waits 4 s. The origin and its multicast on the loopback
are real (`manage.py broadcast`); each joiner is an edge with a socket of its own, at a random moment, and one of them
loses 1 % of what it hears. Counted are whole datagrams with headers of UDP and IP, and what was repaired with 1 kB of
headers for each request. A stall: a segment that is not whole when it is shown, 4 s after its edge's socket was opened
and as far into the movie as it lies.
"""

import asyncio
import contextlib
import json
import math
import os
import random
import subprocess
import sys
import tempfile
from fractions import Fraction
from pathlib import Path
from typing import Any
from urllib.request import urlopen

from benchmarks.stage import set_up, tell

SECONDS, JOINERS, WAIT_S, M = (
    int(os.environ.get("SECONDS", "120")),
    int(os.environ.get("JOINERS", "60")),
    4.0,
    int(os.environ.get("M", "4")),
)
LOSS, LOSSY = 0.01, 1  # of one joiner's packets
KBIT, HZ, SIZE = 500, 10, (320, 240)
GROUP, PORT = "239.8.1.30:15204", 15205
REQUEST = 1000  # bytes of headers of a repair, of TCP and IP, too, in both directions
TCP = 1 + 52 / 1348  # a viewer's own stream, with headers of TCP and IP
GOAL, GOAL_UNICAST = 1.1, 1 / 15
LATEST_S = 20.0


def film(path: Path) -> None:
    """Write a movie of moving noise at an even rate, a key picture each second."""
    import av
    import numpy as np

    numbers = np.random.default_rng(1)
    wide = numbers.integers(0, 255, (SIZE[1] // 8, SIZE[0] // 4, 3), np.uint8).repeat(8, 0).repeat(8, 1)
    rate = f"nal-hrd=cbr:vbv-maxrate={KBIT}:vbv-bufsize={KBIT // 2}:vbv-init=0.5:keyint={HZ}:min-keyint={HZ}:scenecut=0:bframes=0"
    with av.open(str(path), "w", format="mp4") as out:
        stream: Any = out.add_stream("libx264", rate=HZ, options={"preset": "veryfast", "x264-params": rate})
        stream.width, stream.height, stream.pix_fmt, stream.bit_rate = *SIZE, "yuv420p", KBIT * 1000
        for n in range(SECONDS * HZ):
            at = 3 * n % SIZE[0]
            shown = np.ascontiguousarray(wide[:, at : at + SIZE[0]])
            shown = (shown + numbers.integers(0, 40, shown.shape, np.uint8)).astype(np.uint8)
            picture = av.VideoFrame.from_ndarray(shown, "rgb24").reformat(format="yuv420p")
            picture.pts, picture.time_base = n, Fraction(1, HZ)
            out.mux(stream.encode(picture))
        out.mux(stream.encode())


def status() -> dict[str, Any]:
    """Return what the origin counts."""
    with urlopen(f"http://127.0.0.1:{PORT}/status.json", timeout=5) as answer:
        found: dict[str, Any] = json.load(answer)
    return found


class Joiner:
    """An edge that joins, and when it had each segment."""

    def __init__(self, key: bytes, loses: float, seed: int, starts_ns: tuple[int, ...]) -> None:
        from portal.broadcast import multicast, running
        from portal.broadcast.edge import Edge

        numbers = random.Random(seed)
        self.opened_ns, self.starts_ns, self.had_ns = running.now_ns(), starts_ns, []
        group = multicast.group_of(GROUP)
        self.edge = Edge(key, numbers.random)
        self.line = multicast.receiver(group, "lo")
        self.hearing = running.Receiving(
            self.edge, running.Line(self.line, group), f"http://127.0.0.1:{PORT}", lambda: numbers.random() < loses
        )

    def look(self, now_ns: int) -> None:
        """Note what is there."""
        shown = self.edge.current.playable if self.edge.current is not None else 0
        self.had_ns += [now_ns] * (shown - len(self.had_ns))

    @property
    def early_s(self) -> list[float]:
        """How long before it is shown each segment was there; minus infinity where it was not."""
        due = [self.opened_ns + round(WAIT_S * 1e9) + start for start in self.starts_ns[1:]]
        had = [*self.had_ns, *[math.inf] * (len(due) - len(self.had_ns))]
        return [(a - b) / 1e9 for a, b in zip(due, had, strict=True)]


async def joined(key: bytes, starts_ns: tuple[int, ...]) -> tuple[list[Joiner], dict[str, float]]:
    """Let everybody join within the length of the movie; return them, and what the origin sent in that time."""
    from portal.broadcast import running

    numbers = random.Random(1)
    moments = sorted(numbers.uniform(0, SECONDS) for _ in range(JOINERS))
    everybody: list[Joiner] = []
    tasks = []
    before, began, sent = await asyncio.to_thread(status), running.now_ns(), {"held_up_s": 0.0}
    now = began
    while (
        not all(one.edge.current and one.edge.current.whole for one in everybody)
        or len(everybody) < JOINERS
        or not sent
    ):
        await asyncio.sleep(0.005)
        last, now = now, running.now_ns()
        sent["held_up_s"] = max(sent["held_up_s"], (now - last) / 1e9)
        while len(everybody) < JOINERS and (now - began) / 1e9 >= moments[len(everybody)]:
            lossy = len(everybody) in range(JOINERS // 2, JOINERS // 2 + LOSSY)
            everybody.append(Joiner(key, LOSS if lossy else 0, len(everybody), starts_ns))
            tasks.append(asyncio.create_task(everybody[-1].hearing.run()))
        for one in everybody:
            one.look(now)
        took = (now - began) / 1e9
        if took >= SECONDS and "bytes" not in sent:
            after = await asyncio.to_thread(status)
            sent |= {name: (after[name] - before[name]) / took for name in ("packets", "bytes")}
        if took > 2 * SECONDS + WAIT_S + LATEST_S:
            break
    after = await asyncio.to_thread(status)
    sent |= {name: after[name] - before[name] for name in ("repairs", "repaired_bytes", "pauses")}
    sent["late_ms"] = after["late_ms"]
    for task in tasks:
        task.cancel()
    return everybody, sent


def main() -> None:
    """Measure."""
    with contextlib.suppress(PermissionError):  # else other work on the machine makes the joiners deaf
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    set_up()
    from portal.broadcast import media, packets, timetable
    from portal.broadcast.carousel import GUARD_NS
    from portal.broadcast.schedule import harmonic, least, polyharmonic

    secret = "the key of a benchmark"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "day.mp4"
        film(path)
        movie = media.cut(path, round(WAIT_S * 1000 / M))
        command = [
            sys.executable,
            "manage.py",
            "broadcast",
            str(path),
            "--group",
            GROUP,
            "--port",
            str(PORT),
            "--m",
            str(M),
        ]
        origin = subprocess.Popen(
            command, env={**os.environ, "FARHAND_BROADCAST_KEY": secret}, stdout=subprocess.PIPE, text=True
        )
        try:
            assert origin.stdout is not None
            print(origin.stdout.readline().strip())
            asyncio.run(_served())
            everybody, sent = asyncio.run(joined(packets.key_of(secret), movie.starts_ns))
        finally:
            origin.terminate()
            origin.wait(10)
    repaired = (sent["repaired_bytes"] + REQUEST * sent["repairs"]) / SECONDS
    b, bound = movie.rate, least(SECONDS, WAIT_S)
    rate = (sent["bytes"] + packets.UDP_IP * sent["packets"] + repaired) / b
    early = [min(one.early_s) for one in everybody]
    stalls, wrong = sum(e < 0 for e in early), 0
    for one in everybody:
        assert one.edge.current is not None
        parts = [bytes(part.data) for _, part in sorted(one.edge.current.segments.items())]
        wrong += parts != list(movie.contents)
    heads = packets.DATAGRAM - packets.PAYLOAD + packets.UDP_IP
    table = timetable.channels([len(c) for c in movie.contents], movie.starts_ns, round(WAIT_S * 1e9), GUARD_NS)
    expected = float(timetable.bytes_a_second(table, heads)) / b
    beside = {
        "b_kB_s": round(b / 1000, 2), "times_b": round(rate, 3), "timetable_times_b": round(expected, 3),
        "polyharmonic_times_b": round(float(polyharmonic(SECONDS * M // int(WAIT_S), M).bandwidth), 3),
        "H30_times_b": round(float(harmonic(30).bandwidth), 3), "bound_times_b": round(bound, 3),
        "unicast_times_b": round(JOINERS * TCP, 1), "of_unicast": round(rate / (JOINERS * TCP), 4),
        "repaired_kB": round(repaired * SECONDS / 1000, 1), "stalls": stalls, "wrong": wrong,
        "least_early_s": round(min(early), 3), "lost": sum(one.edge.packets_lost for one in everybody),
        "held_up_s": round(sent["held_up_s"], 3), "pauses": sent["pauses"], "origin_late_ms": sent["late_ms"],
        "refused": sum(one.edge.refused for one in everybody),
    }  # fmt: skip
    print(
        f"{JOINERS} joined: {rate:.3f} b ({expected:.3f} by the timetable); H(30) {beside['H30_times_b']} b, the least "
        f"{bound:.3f} b, unicast {JOINERS * TCP:.1f} b; the latest segment {min(early):.3f} s before it was shown"
    )
    tell(
        "harmonic", rate / bound, "times the least bandwidth ln(1 + D/w), with all headers and repairs",
        f"<= {GOAL:g}; a fifteenth of unicast; no stall, every byte right", not stalls and not wrong and rate / bound <= GOAL
        and rate <= GOAL_UNICAST * JOINERS * TCP, beside,
    )  # fmt: skip


async def _served() -> None:
    """Wait until the origin answers."""
    for _ in range(600):
        try:
            await asyncio.to_thread(status)
        except OSError:
            await asyncio.sleep(0.1)
        else:
            return
    raise TimeoutError("The origin does not answer.")
