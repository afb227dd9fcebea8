"""Loads a backup: checked completely in a separate folder, then taken in one transaction or not at all."""

import hashlib
import json
import shutil
import tarfile
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path, PurePosixPath
from typing import Any

from django.conf import settings
from django.core.management import CommandError, call_command
from django.core.serializers.base import DeserializationError
from django.db import DatabaseError, connection, transaction
from django.db.migrations.recorder import MigrationRecorder
from django.db.models import F

from portal.keep.archive import ArchiveError, counts
from robots.grants import end_grant
from robots.kit.clock import SYSTEM
from robots.kit.files import replaced
from robots.models import Command, Grant, Lease, Robot
from robots.recordings import keeping
from robots.services.stopping import NEWEST
from robots.states import COMMAND_RUNNING, CommandState, Cycle, GrantEnd

EPOCHS_AHEAD = 1_000_000  # no worker before the restore can have had a later epoch
RESTORED = "The portal was restored from a backup; whether this was carried out is not known."
BAD = (OSError, tarfile.TarError, zlib.error, EOFError, ValueError, KeyError, TypeError, AttributeError, RecursionError)
SETTINGS = "0018_settings"  # an older backup has columns of single robots
NEW, OLD = ".restoring", ".before-restoring"  # beside the pictures, so that a rename is enough


def read(path: Path, replace: bool = False) -> dict[str, Any]:
    """Load the archive into this portal and return its manifest. If that fails, rows and pictures stay as they were.

    Raises:
        ArchiveError: not an archive, a name outside its folder, a portal that is not empty, another version, or rows or
            pictures that differ from the manifest.
    """
    media = Path(settings.MEDIA_ROOT)
    media.mkdir(parents=True, exist_ok=True)
    _put_back(media)
    staged = media / NEW
    shutil.rmtree(staged, ignore_errors=True)
    try:
        with tempfile.TemporaryDirectory() as rows:
            try:
                with tarfile.open(path) as tar:
                    _unpack(tar, Path(rows), staged)
                manifest = _checked(Path(rows), staged)
            except BAD as error:
                raise ArchiveError(f"{path} is not a readable backup: {error}") from error
            if any(counts().values()) and not replace:
                raise ArchiveError("This portal is not empty. Use --replace to delete what it contains now.")
            try:
                with _put_back_on_error(media), transaction.atomic():
                    _load(Path(rows) / "rows.jsonl", manifest)
                    _swap(media)
                    keeping.settle_restored(SYSTEM.now())
            except (*BAD, CommandError, DeserializationError, DatabaseError) as error:
                raise ArchiveError(f"The rows of {path} cannot be loaded, nothing was changed: {error}") from error
    finally:
        shutil.rmtree(staged, ignore_errors=True)
    shutil.rmtree(media / OLD, ignore_errors=True)
    return manifest


def _inside(name: str) -> PurePosixPath:
    """Return the name as a path inside its folder. Raises ValueError."""
    path = PurePosixPath(name)
    if path.is_absolute() or not path.parts or "\0" in name or any(part.startswith(".") for part in path.parts):
        raise ValueError(f"{name!r} does not belong in a backup")
    return path


def _unpack(tar: tarfile.TarFile, rows: Path, media: Path) -> None:
    """Write the archive's files: pictures to `media`, the rest to `rows`. Refuses links, devices and paths outside."""
    for member in tar:
        path = _inside(member.name)
        source = tar.extractfile(member) if member.isreg() else None
        if source is None:
            raise ValueError(f"{member.name!r} is not a file")
        if path.parts[0] == "media":
            target = media.joinpath(*path.parts[1:])
        elif member.name in ("rows.jsonl", "manifest.json"):
            target = rows / member.name
        else:
            raise ValueError(f"{member.name!r} does not belong in a backup")
        target.parent.mkdir(parents=True, exist_ok=True)
        with source, target.open("xb") as out:
            shutil.copyfileobj(source, out)


def _checked(rows: Path, media: Path) -> dict[str, Any]:
    """Compare the unpacked files with the manifest and return it. Raises ArchiveError."""
    manifest: dict[str, Any] = json.loads((rows / "manifest.json").read_text())
    ours = {f"{a}.{n}" for a, n in MigrationRecorder(connection).applied_migrations()}
    newer = set(manifest["migrations"]) - ours
    if newer:
        raise ArchiveError(f"The backup is of a newer version: it knows {sorted(newer)[0]}. Update first.")
    if manifest.get("rows_sha256", _hash(rows / "rows.jsonl")) != _hash(rows / "rows.jsonl"):  # older backups have none
        raise ArchiveError("The rows are not those of the backup's own list.")
    found = {str(p.relative_to(media)): _hash(p) for p in sorted(media.rglob("*")) if p.is_file()}
    wrong = {name for name, _ in found.items() ^ dict(manifest["media"]).items()}
    if wrong:
        raise ArchiveError(f"The pictures are not those of the backup's own list, first {sorted(wrong)[0]}.")
    return manifest


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _swap(media: Path) -> None:
    """Replace the present pictures by the unpacked ones."""
    old = media / OLD
    old.mkdir()
    for path in [p for p in media.iterdir() if p.name not in (NEW, OLD)]:
        path.rename(old / path.name)
    for path in [*(media / NEW).iterdir()] if (media / NEW).exists() else []:
        path.rename(media / path.name)


@contextmanager
def _put_back_on_error(media: Path) -> Iterator[None]:
    """Undo a swap of pictures if anything fails after it, the commit of the rows too."""
    try:
        yield
    except BaseException:
        _put_back(media)
        raise


def _put_back(media: Path) -> None:
    """Undo a swap that an error or a kill interrupted."""
    old = media / OLD
    if not old.exists():
        return
    for path in [p for p in media.iterdir() if p.name not in (NEW, OLD)]:
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    for path in [*old.iterdir()]:
        path.rename(media / path.name)
    old.rmdir()


def _load(rows: Path, manifest: dict[str, Any]) -> None:
    if any(counts().values()):
        call_command("flush", interactive=False, verbosity=0)
    if f"robots.{SETTINGS}" not in manifest["migrations"]:
        _move_settings(rows)
    call_command("loaddata", str(rows), verbosity=0)
    found = counts()
    wrong = [kind for kind, number in manifest["rows"].items() if found.get(kind) != number]
    if wrong:
        raise ValueError(f"they are not those of the backup's own list, first {wrong[0]}")
    _close_what_was_open()


def _move_settings(path: Path) -> None:
    """Change the rows of an older backup as the migration changes those of a database."""
    migration = import_module(f"robots.migrations.{SETTINGS}")
    with path.open() as lines, replaced(path) as out:
        for line in lines:
            row = json.loads(line)
            if row["model"] == "robots.robot":
                old = {name: row["fields"].pop(name) for name in migration.OLD if name in row["fields"]}
                row["fields"]["settings"] = migration.moved(old)
                line = json.dumps(row) + "\n"
            out.write(line.encode())


def _close_what_was_open() -> None:
    """End everything that was open: robots are stopped and verified again, epochs start far ahead.

    They are stopped because the backup does not know of a stop or a lock-out that came after it.
    """
    now = SYSTEM.now()
    Command.objects.filter(state__in=[*COMMAND_RUNNING, CommandState.QUEUED]).update(
        state=CommandState.UNKNOWN, reason=RESTORED, ended_at=now
    )
    for grant in Grant.objects.select_related("robot").filter(ended_at=None):
        end_grant(grant, GrantEnd.RESTORED, "restored from a backup", now)
    Lease.objects.update(epoch=F("epoch") + EPOCHS_AHEAD, expires_at=None, pid=0)
    Robot.objects.update(stop_latched=True, stopped_at=now, stopped_after=NEWEST, stop_confirmed=False)
    Robot.objects.exclude(cycle=Cycle.LOCKED_OUT).update(cycle=Cycle.OFFLINE)
