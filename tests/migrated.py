"""A migrated SQLite database that test processes copy, because to migrate takes each of them some seconds."""

import hashlib
import os
import shutil
import sqlite3
from pathlib import Path

from django.apps import apps
from django.db import connection

FOLDER = Path(__file__).resolve().parent.parent / "var"


def copied() -> bool:
    """Begin with a copy of a database migrated before; tell whether there was one."""
    if connection.vendor != "sqlite" or not _kept().exists():
        return False
    shutil.copyfile(_kept(), connection.settings_dict["TEST"]["NAME"])
    return True


def keep() -> None:
    """Keep a copy of the migrated database for the processes after this one, unless there is one."""
    if connection.vendor != "sqlite" or _kept().exists():
        return
    beside = FOLDER / f"migrated-{os.getpid()}.part"
    copy = sqlite3.connect(beside)
    connection.ensure_connection()
    connection.connection.backup(copy)
    copy.close()
    for old in FOLDER.glob("migrated-*.sqlite3"):
        old.unlink(missing_ok=True)
    beside.replace(_kept())


def _kept() -> Path:
    """Return the file's name, which changes with any migration. What models add by themselves, `migrate` makes anew."""
    total = hashlib.sha256()
    for app in apps.get_app_configs():
        for file in sorted(Path(app.path).glob("migrations/*.py")):
            total.update(f"{app.label} {file.name} ".encode() + file.read_bytes())
    return FOLDER / f"migrated-{total.hexdigest()[:16]}.sqlite3"
