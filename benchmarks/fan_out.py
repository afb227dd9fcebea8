"""Pictures to many viewers: our web process beside Channels' `group_send` and the least that a server can do.

The server has one core, whatever it is; Redis, the process that makes the pictures and the viewers have the other.
Each picture has 6 kB, ten come a second. Judged is processor time of the server for each delivered picture; twenty
times cheaper than `group_send` only where the least that a server can do is that: with few viewers it is not.
"""

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import psutil

from benchmarks.stage import cast, database, set_up, tell

ROOT = Path(__file__).resolve().parent.parent
COMPARED, LAYERS = ("raw", "ours"), ("group", "group_pubsub")
TURNS = 3  # of the compared ways, one after the other: what else runs on the machine affects both
VIEWERS = [int(n) for n in os.environ.get("VIEWERS", "100,500,1000,2000").split(",")]
SECONDS = float(os.environ.get("SECONDS_EACH", "10"))
TIMES, SHARE = 20, 0.8  # times as cheap as group_send; share of the raw way
BEHIND_MS = 200  # a picture that comes later is more than one picture behind
PATH = "/ws/robots/mercury/"


def main() -> None:
    """Measure each way with each number of viewers; the last line judges the largest number."""
    set_up()
    with database():
        found = {n: _all(n) for n in VIEWERS}
    for n, ways in found.items():
        for way, one in ways.items():
            print(
                f"{n:5d} viewers, {way:12s}: {one['rate']:8.0f} pictures/s ({one['share']:4.0%} of those wanted), "
                f"{one['us']:6.1f} us of the server each, delay {one['median_ms']:.1f} ms, 99 % {one['p99_ms']:.1f} ms, "
                f"at most {one['most_ms']:.0f} ms, {one['kB']:.1f} kB a viewer"
            )
    shares = {n: ways["ours"]["of_raw"] for n, ways in found.items()}
    times = {n: ways["group"]["us"] / ways["ours"]["us"] for n, ways in found.items()}
    behind = max(ways["ours"]["most_ms"] for ways in found.values())
    possible = {n for n, ways in found.items() if ways["group"]["us"] / ways["raw"]["us"] >= TIMES}
    cheap = bool(possible) and all(times[n] >= TIMES for n in possible)
    holds = min(shares.values()) >= SHARE and cheap and behind <= BEHIND_MS
    beside = {
        "times_group_send": {n: round(t, 1) for n, t in times.items()},
        "share_of_raw": {n: round(s, 2) for n, s in shares.items()},
        "most_ms": round(behind), "at": found,
    }  # fmt: skip
    tell(
        "fan_out",
        min(shares.values()),
        "of the raw way, processor time of the server for each delivered picture, the worst number of viewers",
        f">= {SHARE:g}, >= {TIMES} times as cheap as group_send where raw is that, no picture later than {BEHIND_MS} ms",
        holds,
        beside,
    )


def _all(viewers: int) -> dict[str, dict[str, float]]:
    """Return the middle one of some turns of the compared ways, judged turn by turn, and one of each other way."""
    turns = [{way: _measure(way, viewers) for way in COMPARED} for _ in range(TURNS)]
    for turn in turns:
        turn["ours"]["of_raw"] = turn["raw"]["us"] / turn["ours"]["us"]
    turns.sort(key=lambda turn: turn["ours"]["of_raw"])
    return turns[TURNS // 2] | {way: _measure(way, viewers) for way in LAYERS}


def _measure(way: str, viewers: int) -> dict[str, float]:
    """Return what one way does for so many viewers."""
    from django.conf import settings

    from tests.conftest import RedisServer

    with ExitStack() as stack:
        redis = RedisServer()
        redis.start()
        stack.callback(redis.stop)
        psutil.Process(redis.process.pid).cpu_affinity([1])
        process, url = stack.enter_context(server(way, settings.REDIS_URL))
        maker = child("_fans", "publish", way, settings.REDIS_URL)
        stack.callback(maker.kill)
        crowd = child("_crowd", url, str(viewers), str(SECONDS), talk=True)
        stack.callback(crowd.kill)
        first = line(crowd)["joined"]
        before = process.memory_full_info().uss
        go_on(crowd)
        joined = line(crowd)["joined"]
        grown = process.memory_full_info().uss - before
        used = _used_s(process)
        go_on(crowd)
        seen = line(crowd)
        used = _used_s(process) - used
    return {
        "rate": seen["pictures"] / seen["seconds"],
        "share": seen["pictures"] / seen["wanted"],
        "us": used / seen["pictures"] * 1e6,
        "kB": grown / (joined - first) / 1000,
        **{name: round(seen[name], 2) for name in ("median_ms", "p99_ms", "most_ms", "lost", "without")},
    }


def _used_s(process: psutil.Process) -> float:
    """Return the processor time of all threads, to the nanosecond."""
    tasks = Path(f"/proc/{process.pid}/task").glob("*/schedstat")
    return sum(int(task.read_text().split()[0]) for task in tasks) / 1e9


def child(module: str, *arguments: str, talk: bool = False) -> Any:
    """Start a process of the benchmark on the second core."""
    pipe = subprocess.PIPE if talk else subprocess.DEVNULL
    made = subprocess.Popen(
        [sys.executable, "-m", f"benchmarks.{module}", *arguments], cwd=ROOT, text=True, stdin=pipe, stdout=pipe
    )
    psutil.Process(made.pid).cpu_affinity([1])
    return made


def line(process: Any) -> dict[str, Any]:
    """Return the next line that a process says."""
    said = process.stdout.readline()
    if not said:
        raise SystemExit("the viewers ended; what went wrong is above")
    found: dict[str, Any] = json.loads(said)
    return found


def go_on(process: Any) -> None:
    """Answer a line."""
    process.stdin.write("\n")
    process.stdin.flush()


@contextlib.contextmanager
def server(way: str, store: str) -> Iterator[tuple[psutil.Process, str]]:
    """Run a server on the first core; yield its process and its address."""
    from tests.conftest import wait_for
    from tests.rig import Web, free_port

    if way == "ours":
        from robots.models import Robot

        if not Robot.objects.exists():
            cast()
        web = Web(FARHAND_SOCKETS_PER_ADDRESS="5000", FARHAND_CONNECTIONS_PER_ADDRESS="5000")
        psutil.Process(web.pid).cpu_affinity([0])
        try:
            yield psutil.Process(web.pid), web.url + PATH
        finally:
            web.kill()
        return
    port = free_port()
    made = subprocess.Popen(
        [sys.executable, "-m", "benchmarks._fans", "serve", way, str(port), store], cwd=ROOT, stdin=subprocess.DEVNULL
    )
    process = psutil.Process(made.pid)
    process.cpu_affinity([0])
    try:
        wait_for(lambda: any(c.laddr.port == port for c in process.net_connections()), 30, f"the server {way}")
        yield process, f"http://127.0.0.1:{port}/"
    finally:
        made.kill()
        made.wait()
