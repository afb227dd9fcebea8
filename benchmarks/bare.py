"""A bare Celery task with a result backend: what the round trip is measured beside."""

import os

from celery import Celery

_url = os.environ["REDIS_URL"]
app = Celery("bare", broker=_url.replace("unix://", "redis+socket://"), backend=_url.replace("unix://", "redis+socket://"))
app.conf.worker_disable_prefetch = True
app.conf.worker_prefetch_multiplier = 1
app.conf.task_default_queue = "bare"


@app.task  # type: ignore[untyped-decorator]
def nothing() -> int:
    """Do nothing."""
    return 1
