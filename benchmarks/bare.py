"""A bare Celery task with a result backend: what the round trip is measured beside.

Run as a process it is the client: `python -m benchmarks.bare RUNS` prints the times in ms.
"""

import json
import os
import sys
import time

from celery import Celery

_url = os.environ["REDIS_URL"]
app = Celery(
    "bare", broker=_url.replace("unix://", "redis+socket://"), backend=_url.replace("unix://", "redis+socket://")
)
app.conf.worker_prefetch_multiplier = 1
app.conf.task_default_queue = "bare"


@app.task  # type: ignore[untyped-decorator]
def nothing() -> int:
    """Do nothing."""
    return 1


if __name__ == "__main__":
    from benchmarks.bare import nothing as task  # the worker knows it by this module's name

    times = []
    for _ in range(int(sys.argv[1])):
        begun = time.perf_counter()
        assert task.delay().get(timeout=10) == 1
        times.append((time.perf_counter() - begun) * 1000)
        time.sleep(0.055)
    print(json.dumps(times))
