"""The Celery app; the only module that names `workers`, to add the bootsteps of owner and scheduler."""

import os
import sys

os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")

from celery import Celery, signals

# Celery's fixup for Django puts the working folder first in sys.path; it may contain another folder `robots`
_path = list(sys.path)
app = Celery("portal")
sys.path[:] = _path
app.config_from_object("django.conf:settings", namespace="CELERY")
app.autodiscover_tasks(["queueing"])


@signals.celeryd_init.connect
def _prepare_worker(**_: object) -> None:
    """Load the owner's modules, in workers only; pages never import them."""
    from workers import tasks  # noqa: F401, PLC0415
    from workers.bootstep import STEPS  # noqa: PLC0415

    app.steps["worker"].update(STEPS)


@signals.task_prerun.connect
@signals.task_postrun.connect
def _close_old_connections(**_: object) -> None:
    """Keep a thread's connection to the database between tasks, as Django does between requests.

    Celery's own rule, a new connection for each task, makes the database read its schema again each time.
    """
    from django.db import close_old_connections  # noqa: PLC0415 - after the settings

    close_old_connections()
