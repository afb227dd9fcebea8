"""One file with everything worth keeping: rows and pictures, with counts and hashes to compare by."""

import hashlib
import io
import json
import shutil
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from django.apps import apps
from django.conf import settings
from django.core import serializers
from django.core.management import call_command
from django.db import connection, models, transaction
from django.db.migrations.recorder import MigrationRecorder
from django.db.models import F

from robots.clock import SYSTEM
from robots.models import Command, Grant, Lease, Robot
from robots.states import COMMAND_RUNNING, CommandState, Cycle

LEFT_OUT = {"contenttypes.contenttype", "auth.permission", "sessions.session"}
EPOCHS_AHEAD = 1_000_000  # no worker of before the restore may ever have held a later epoch
RESTORED = "The portal was restored from a backup; what became of this is not known."


class ArchiveError(Exception):
    """The archive cannot be written or taken; says why."""


def kept_models() -> list[type[models.Model]]:
    """Return the models whose rows are kept, in an order that can be loaded."""
    ordered = serializers.sort_dependencies([(a, None) for a in apps.get_app_configs()], allow_cycles=True)
    return [m for m in ordered if m._meta.label_lower not in LEFT_OUT and m._meta.managed and not m._meta.proxy]


def counts() -> dict[str, int]:
    """Return the number of rows of each model."""
    return {m._meta.label_lower: m._default_manager.count() for m in kept_models()}


def _media(folder: Path) -> Iterator[tuple[str, bytes]]:
    """Go through the files under `folder`: path there, content."""
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.suffix != ".part":
            yield str(path.relative_to(folder)), path.read_bytes()


def media_hashes(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of each file under `folder`, by its path there."""
    return {name: hashlib.sha256(data).hexdigest() for name, data in _media(folder)}


@contextmanager
def _one_moment() -> Iterator[None]:
    """Read everything as it was at one moment, without keeping anybody from writing."""
    if connection.vendor == "sqlite":
        connection.ensure_connection()
        connection.cursor().execute("BEGIN DEFERRED")  # Django's own would take the write lock
        try:
            yield
        finally:
            connection.cursor().execute("ROLLBACK")
    else:
        with transaction.atomic():
            connection.cursor().execute("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ READ ONLY")
            yield


def write(path: Path) -> dict[str, Any]:
    """Write the archive to `path`; return its manifest. Raises ArchiveError."""
    folder = Path(settings.MEDIA_ROOT)
    part = path.with_name(path.name + ".part")
    try:
        with tarfile.open(part, "w:gz") as tar, tempfile.TemporaryFile("w+", encoding="utf-8") as rows:
            with _one_moment():
                manifest: dict[str, Any] = {"made_at": SYSTEM.now().isoformat(), "rows": counts(), "media": {}}
                for model in kept_models():
                    query = model._default_manager.order_by("pk").iterator(chunk_size=500)
                    serializers.serialize("jsonl", query, use_natural_foreign_keys=True, stream=rows)
                applied = MigrationRecorder(connection).applied_migrations()
                manifest["migrations"] = sorted(f"{app}.{name}" for app, name in applied)
            for name, data in _media(folder):
                manifest["media"][name] = hashlib.sha256(data).hexdigest()
                _add(tar, f"media/{name}", data)
            rows.seek(0)
            _add(tar, "rows.jsonl", rows.read().encode())
            _add(tar, "manifest.json", json.dumps(manifest, indent=1).encode())
    except OSError as error:
        part.unlink(missing_ok=True)
        raise ArchiveError(f"The backup could not be written to {path}: {error.strerror}.") from error
    part.replace(path)
    return manifest


def _add(tar: tarfile.TarFile, name: str, data: bytes) -> None:
    info = tarfile.TarInfo(name)
    info.size, info.mtime = len(data), int(SYSTEM.now().timestamp())
    tar.addfile(info, io.BytesIO(data))


def read(path: Path, replace: bool = False) -> dict[str, Any]:
    """Load the archive into this portal and compare; return its manifest.

    Raises:
        ArchiveError: no archive, a portal that is not empty, another version, a difference.

    """
    try:
        with tarfile.open(path) as tar, tempfile.TemporaryDirectory() as temporary:
            _unpack(tar, Path(temporary).resolve())
            return _load(Path(temporary), replace)
    except (OSError, tarfile.TarError, ValueError, KeyError) as error:
        raise ArchiveError(f"{path} is no backup that can be read: {error}") from error


def _unpack(tar: tarfile.TarFile, folder: Path) -> None:
    """Write the archive's files below `folder`; nothing else belongs in one. Python before 3.11.4 has no filters."""
    for member in tar:
        source, target = tar.extractfile(member) if member.isreg() else None, (folder / member.name).resolve()
        if source is None or not target.is_relative_to(folder):
            raise tarfile.TarError(f"{member.name} does not belong in a backup")
        target.parent.mkdir(parents=True, exist_ok=True)
        with source, target.open("wb") as out:
            shutil.copyfileobj(source, out)


def _load(folder: Path, replace: bool) -> dict[str, Any]:
    manifest: dict[str, Any] = json.loads((folder / "manifest.json").read_text())
    ours = {f"{a}.{n}" for a, n in MigrationRecorder(connection).applied_migrations()}
    newer = set(manifest["migrations"]) - ours
    if newer:
        raise ArchiveError(f"The backup is of a newer version: it knows {sorted(newer)[0]}. Update first.")
    if any(counts().values()):
        if not replace:
            raise ArchiveError("This portal is not empty. Use --replace to throw away what it holds now.")
        call_command("flush", interactive=False, verbosity=0)
    with transaction.atomic():
        call_command("loaddata", str(folder / "rows.jsonl"), verbosity=0)
    media = Path(settings.MEDIA_ROOT)
    for name in manifest["media"]:
        target = media / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes((folder / "media" / name).read_bytes())
    found, hashes = counts(), media_hashes(media)
    wrong = [k for k, n in manifest["rows"].items() if found.get(k) != n]
    wrong += [k for k, h in manifest["media"].items() if hashes.get(k) != h]
    if wrong:
        raise ArchiveError(f"The restored portal differs from the backup, first in {wrong[0]}.")
    _close_what_was_open()
    return manifest


def _close_what_was_open() -> None:
    """Nothing that was under way goes on: robots are verified anew, epochs start far ahead."""
    now = SYSTEM.now()
    Grant.objects.filter(ended_at=None).update(ended_at=now, end_reason="restored from a backup")
    Command.objects.filter(state__in=[*COMMAND_RUNNING, CommandState.QUEUED]).update(
        state=CommandState.UNKNOWN, reason=RESTORED, ended_at=now
    )
    Lease.objects.update(epoch=F("epoch") + EPOCHS_AHEAD, expires_at=None, pid=0)
    Robot.objects.exclude(cycle=Cycle.LOCKED_OUT).update(cycle=Cycle.OFFLINE)
