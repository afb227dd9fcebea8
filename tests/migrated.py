"""A migrated database that test processes copy, because to migrate takes each of them some seconds."""

import fcntl
import hashlib
import os
import shutil
import sqlite3
import subprocess
from pathlib import Path
from typing import IO

from django.apps import apps
from django.db import connection

FOLDER = Path(__file__).resolve().parent.parent / "var"
ENDINGS = {"sqlite": "sqlite3", "postgresql": "sql"}


class OneAtATime:
    """Lets one process migrate while those that begin beside it wait for its copy."""

    _file: IO[str] | None = None

    def take(self) -> None:
        FOLDER.mkdir(exist_ok=True)
        self._file = (FOLDER / "migrated.lock").open("w")
        fcntl.flock(self._file, fcntl.LOCK_EX)

    def over(self) -> None:
        if self._file is not None:
            self._file.close()


MIGRATING = OneAtATime()


def copied() -> bool:
    """Begin with a copy of a database migrated before; tell whether there was one. If not, `keep` has to follow."""
    if not _kept().exists():
        MIGRATING.take()
        if not _kept().exists():
            return False
        MIGRATING.over()
    name = connection.creation._get_test_db_name()
    if connection.vendor == "sqlite":
        shutil.copyfile(_kept(), name)
    else:
        with connection.creation._nodb_cursor() as cursor:
            cursor.execute(f'create database "{name}"')
        _program("psql", "-q", "-v", "ON_ERROR_STOP=1", "-f", str(_kept()), name)
    return True


def begin(file: Path) -> None:
    """Let a SQLite file of a portal of its own begin with what was migrated before; without that it migrates itself."""
    if connection.vendor == "sqlite" and _kept().exists():
        shutil.copyfile(_kept(), file)


def keep() -> None:
    """Keep a copy of the migrated database for the processes that wait and those after this one, unless there is one."""
    if not _kept().exists():
        _copy()
    MIGRATING.over()


def _copy() -> None:
    beside = FOLDER / f"migrated-{os.getpid()}.part"
    if connection.vendor == "sqlite":
        copy = sqlite3.connect(beside)
        connection.ensure_connection()
        connection.connection.backup(copy)
        copy.close()
    else:
        _program("pg_dump", "-f", str(beside), connection.settings_dict["NAME"])
    for old in FOLDER.glob(f"migrated-*.{_kept().suffix}"):
        old.unlink(missing_ok=True)
    beside.replace(_kept())


def leave_alone() -> None:
    """End other sessions of the database, which could not be dropped: of a process just killed, of a test's thread."""
    if connection.vendor == "postgresql":
        with connection.cursor() as cursor:
            cursor.execute(
                "select pg_terminate_backend(pid, 5000) from pg_stat_activity"
                " where datname = current_database() and pid <> pg_backend_pid()"
            )


def _kept() -> Path:
    """Return the file's name, which changes with any migration. What models add by themselves, `migrate` makes anew."""
    total = hashlib.sha256()
    for app in apps.get_app_configs():
        for file in sorted(Path(app.path).glob("migrations/*.py")):
            total.update(f"{app.label} {file.name} ".encode() + file.read_bytes())
    return FOLDER / f"migrated-{total.hexdigest()[:16]}.{ENDINGS[connection.vendor]}"


def _program(name: str, *arguments: str) -> None:
    """Run a program of the server's own version."""
    with connection.creation._nodb_cursor() as cursor:
        cursor.execute("select setting from pg_config where name = 'BINDIR'")
        program = Path(cursor.fetchone()[0]) / name
    db = connection.settings_dict
    subprocess.run([program, "-h", db["HOST"], "-U", db["USER"], *arguments], check=True, stdout=subprocess.DEVNULL)
