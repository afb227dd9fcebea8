"""The Celery app. Workers alone load `CELERY_IMPORTS`, which adds the steps of owner and scheduler; pages never do."""

import os
import sys

os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")

from celery import Celery, signals

from portal.logs.outlet import ERRORS
from portal.logs.text import PRINTED, tidy

# Celery's fixup for Django puts the working folder first in sys.path; it may contain another folder `robots`
_path = list(sys.path)
app = Celery("portal")
sys.path[:] = _path
app.config_from_object("django.conf:settings", namespace="CELERY")
app.autodiscover_tasks(["queueing", *(f"portal.web.{one}" for one in ("daily", "alerts", "feeds", "push"))])


@signals.task_prerun.connect
@signals.task_postrun.connect
def _close_old_connections(**_: object) -> None:
    """Keep a thread's connection to the database between tasks, as Django does between requests.

    Celery's own rule, a new connection for each task, makes the database read its schema again each time.
    """
    from django.db import close_old_connections  # noqa: PLC0415 - after the settings

    close_old_connections()


@signals.celeryd_init.connect
def _say_without_waiting(**_: object) -> None:
    """Let Celery's signal handlers wait for no log: a SIGTERM would not hold the robot while nobody reads it."""
    from celery.apps import worker  # noqa: PLC0415 - workers only

    worker.safe_say = lambda message, f=None: ERRORS.write(tidy(str(message), PRINTED))
