"""Settings that depend on a process's role (web, owner, housekeeping, recorder): waits for stores, SQLite's log.

`portal/settings.py` reads it for the role in the environment. A fork of a process that has read the settings already
takes its own role with `take`.
"""

from typing import Any

REDIS_TIMEOUT_S = 0.2
CONSUMERS = ("owner", "housekeeping")


def database_options(engine: str, role: str) -> dict[str, Any]:
    """Return the options of the database that depend on the role; an owner has to renew a lease of three seconds.

    A commit that finds SQLite's log grown to `wal_autocheckpoint` pages of 4 KiB writes the log back into the database
    (a checkpoint), which takes as long as the disk needs. So housekeeping does it early, and a process on a command's
    path only where housekeeping did not.
    """
    if engine.endswith("sqlite3"):
        pages = 1000 if role == "housekeeping" else 8000
        return {
            "timeout": 2 if role == "owner" else 20,
            "init_command": f"PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA wal_autocheckpoint={pages};",
        }
    return {"wait_s": 2.0 if role == "owner" else 10.0}


def broker_options(role: str) -> dict[str, Any]:
    """Return the options of Celery's broker: consumers wait for it, all other processes go on without it."""
    if role in CONSUMERS:
        return {"socket_timeout": 30, "socket_connect_timeout": 3, "socket_keepalive": True, "health_check_interval": 5}
    return {"socket_timeout": REDIS_TIMEOUT_S, "socket_connect_timeout": REDIS_TIMEOUT_S, "max_retries": 0}


def take(role: str) -> None:
    """Use the waits of `role` in this process, a fork that has opened no store yet, if the settings were read."""
    from django.conf import settings  # noqa: PLC0415 - the settings themselves import this module

    if not settings.configured:
        return
    settings.ROLE = role
    database, broker = settings.DATABASES["default"], settings.CELERY_BROKER_TRANSPORT_OPTIONS
    database["OPTIONS"].update(database_options(database["ENGINE"], role))
    broker.clear()  # in place: Django and Celery may hold both already
    broker.update(broker_options(role))
