"""The few Celery tasks of a robot: the bell, the test of a connection, the broom."""

import shutil
from datetime import timedelta
from pathlib import Path

from celery import shared_task
from celery.worker import state
from django.conf import settings

from robots import bus
from robots.clock import SYSTEM
from robots.models import Frame
from workers import bootstep, probing


@shared_task(name="robots.look", ignore_result=True, max_retries=0)
def look() -> None:
    """Answer the bell: the owner looks at its command rows."""
    if bootstep.runtime is not None:
        bootstep.runtime.look()


@shared_task(name=bus.PROBE_TASK, ignore_result=True, max_retries=0)
def probe() -> None:
    """Carry out the tests that are asked for, one at a time; who comes meanwhile has nothing to do."""
    probing.all_that_wait(lambda: state.should_stop is not None)


@shared_task(name="robots.clean", ignore_result=True, max_retries=0)
def clean() -> int:
    """Remove pictures past their time that nothing refers to; return how many."""
    before = SYSTEM.now() - timedelta(days=settings.FRAME_KEEP_DAYS)
    removed = 0
    for frame in Frame.objects.filter(taken_at__lt=before, kept=False).iterator():
        (Path(settings.MEDIA_ROOT) / frame.file).unlink(missing_ok=True)
        frame.delete()
        removed += 1
    for folder in Path(settings.MEDIA_ROOT).glob("frames/*/*"):
        if folder.is_dir() and not any(folder.iterdir()):
            shutil.rmtree(folder, ignore_errors=True)
    return removed
