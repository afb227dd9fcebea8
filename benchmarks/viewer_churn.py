"""The web process's memory while viewers come and go for half an hour: it must not grow.

500 watch pictures of 6 kB, ten a second; five leave and five others join each second. The memory of the second third is
compared with that of the last; the first is for what is loaded once.
"""

import os
import statistics
import threading
import time
from contextlib import ExitStack

import psutil

from benchmarks.fan_out import child, go_on, line, server
from benchmarks.stage import database, set_up, tell

MINUTES = float(os.environ.get("MINUTES", "30"))
VIEWERS, CHANGES = 500, 5
SAMPLE_S = 5.0
GROWTH = 1.02


def main() -> None:
    """Measure."""
    set_up()
    with database(), ExitStack() as stack:
        found = _measure(stack)
    samples = found["samples"]
    third = len(samples) // 3
    before, after = statistics.median(samples[third : 2 * third]), statistics.median(samples[2 * third :])
    growth = after / before
    print(
        f"{MINUTES:g} min, {found['joined']:.0f} joined in all: {before / 1e6:.1f} MB in the second third, "
        f"{after / 1e6:.1f} MB in the last; {found['lost']:.0f} were cut off"
    )
    beside = {"before_MB": round(before / 1e6, 2), "after_MB": round(after / 1e6, 2), "lost": found["lost"]}
    tell(
        "viewer_churn", growth, "times the memory of the second third, in the last third",
        f"<= {GROWTH:g} after 30 min, nobody cut off", growth <= GROWTH and not found["lost"], beside,
    )  # fmt: skip


def _measure(stack: ExitStack) -> dict[str, float | list[int]]:
    from django.conf import settings

    from tests.conftest import RedisServer

    redis = RedisServer()
    redis.start()
    stack.callback(redis.stop)
    web, url = stack.enter_context(server("ours", settings.REDIS_URL))
    stack.callback(child("_fans", "publish", "ours", settings.REDIS_URL).kill)
    crowd = child("_crowd", url, str(VIEWERS), str(MINUTES * 60), "--changes", str(CHANGES), talk=True)
    stack.callback(crowd.kill)
    samples: list[int] = []
    over = threading.Event()

    def sample() -> None:
        while not over.wait(SAMPLE_S):
            samples.append(psutil.Process(web.pid).memory_full_info().uss)

    for _ in range(2):
        line(crowd)
        go_on(crowd)
    begun = time.monotonic()
    threading.Thread(target=sample, daemon=True).start()
    seen = line(crowd)
    over.set()
    return {"samples": samples, "lost": seen["lost"], "joined": VIEWERS + CHANGES * (time.monotonic() - begun)}
