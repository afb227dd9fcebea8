"""What depends on a process's role."""

import sqlite3
from contextlib import closing

import pytest

from portal.run.roles import database_options

SQLITE = "django.db.backends.sqlite3"


def checkpoint_pages(role, path):
    """Return after how many pages of SQLite's log a process of that role writes them back."""
    with closing(sqlite3.connect(path, timeout=database_options(SQLITE, role)["timeout"])) as db:
        db.executescript(database_options(SQLITE, role)["init_command"])
        return db.execute("PRAGMA wal_autocheckpoint").fetchone()[0]


@pytest.mark.parametrize("role", ["web", "owner", "recorder"])
def test_housekeeping_writes_sqlites_log_back_before_anybody_on_a_commands_path_does(role, tmp_path):
    assert checkpoint_pages("housekeeping", tmp_path / "db") * 4 <= checkpoint_pages(role, tmp_path / "db")


@pytest.mark.parametrize("role", ["web", "owner", "recorder", "housekeeping"])
def test_every_commit_of_every_role_is_on_the_disk(role, tmp_path):
    with closing(sqlite3.connect(tmp_path / "db")) as db:
        db.executescript(database_options(SQLITE, role)["init_command"])
        assert db.execute("PRAGMA synchronous").fetchone() == (2,)
        assert db.execute("PRAGMA journal_mode").fetchone() == ("wal",)


def test_an_owner_waits_less_than_its_lease_lasts():
    assert database_options(SQLITE, "owner")["timeout"] < 3
    assert database_options("portal.postgres", "owner")["wait_s"] < 3
