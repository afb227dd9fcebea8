"""The database between two tests: emptied row by row, because a flush creates every permission again."""

import time  # noqa: TID251 - a pause

from django.db import IntegrityError, OperationalError, connection, transaction

MADE_ONCE = {"django_migrations", "django_content_type", "auth_permission"}
TRIES = 5


def wipe(robot: int | None = None) -> None:
    """Empty every table but what migrations made once; `robot` is the key of one whose process goes on."""
    for left in range(TRIES)[::-1]:
        try:
            _wipe(robot)
            return
        except (OperationalError, IntegrityError):  # a process at work holds a lock, or wrote a row meanwhile
            if not left:
                raise
            time.sleep(0.2)


def _wipe(robot: int | None) -> None:
    spared = {
        "robots_robot": f"id = {robot}",
        "robots_lease": f"robot_id = {robot}",
        "queueing_queuerobot": f"robot_id = {robot}",
        "queueing_queue": f"id in (select queue_id from queueing_queuerobot where robot_id = {robot})",
    }
    tables = set(connection.introspection.django_table_names(only_existing=True)) - MADE_ONCE
    with transaction.atomic(), connection.cursor() as cursor:
        for table in sorted(tables, key=list(spared).__contains__):  # foreign keys are checked at the end
            where = f" where not ({spared[table]})" if robot is not None and table in spared else ""
            cursor.execute(f'delete from "{table}"{where}')
