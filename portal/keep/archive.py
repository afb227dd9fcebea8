"""The backup: one file with all rows and pictures, with counts and hashes to compare."""

import hashlib
import io
import json
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from django.apps import apps
from django.conf import settings
from django.core import serializers
from django.db import connection, models, transaction
from django.db.migrations.recorder import MigrationRecorder

from robots.kit.clock import SYSTEM
from robots.kit.files import replaced
from robots.recordings.keeping import BUSY, FOLDER, LIVE, MOVIES, OLD

LEFT_OUT = {"contenttypes.contenttype", "auth.permission", "sessions.session", "queueing.turnsession", "robots.movie"}
UNFINISHED = {".part", LIVE, BUSY, OLD}


class ArchiveError(Exception):
    """The archive cannot be written or loaded; the message says why."""


def kept_models() -> list[type[models.Model]]:
    """Return the models whose rows are archived, in an order in which they can be loaded."""
    ordered = serializers.sort_dependencies([(a, None) for a in apps.get_app_configs()], allow_cycles=True)
    return [m for m in ordered if m._meta.label_lower not in LEFT_OUT and m._meta.managed and not m._meta.proxy]


def counts() -> dict[str, int]:
    """Return the number of rows of each model."""
    return {m._meta.label_lower: m._default_manager.count() for m in kept_models()}


def _media(folder: Path, without: frozenset[str] = frozenset()) -> Iterator[tuple[str, bytes]]:
    """Yield path and content of each file under `folder`, except files that can be made again and half-written ones."""
    for path in sorted(folder.rglob("*")):
        first = path.relative_to(folder).parts[0]
        whole = path.is_file() and path.suffix not in UNFINISHED
        if whole and first[:1] != "." and first not in without | {MOVIES}:
            yield str(path.relative_to(folder)), path.read_bytes()


def media_hashes(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of each file under `folder`, by its relative path."""
    return {name: hashlib.sha256(data).hexdigest() for name, data in _media(folder)}


@contextmanager
def _one_moment() -> Iterator[None]:
    """Let all queries in the body read the rows of one moment, while others go on writing."""
    if connection.vendor == "sqlite":
        connection.ensure_connection()
        connection.cursor().execute("BEGIN DEFERRED")  # Django's own statement would take the write lock
        try:
            yield
        finally:
            connection.cursor().execute("ROLLBACK")
    else:
        with transaction.atomic():
            connection.cursor().execute("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ READ ONLY")
            yield


def write(path: Path, recordings: bool = True) -> dict[str, Any]:
    """Write the archive to `path`, with or without recordings' files; return its manifest. Raises ArchiveError."""
    without = frozenset() if recordings else frozenset({FOLDER})
    folder = Path(settings.MEDIA_ROOT)
    try:
        with (
            replaced(path) as out,
            tarfile.open(fileobj=out, mode="w:gz") as tar,
            tempfile.TemporaryFile("w+", encoding="utf-8") as rows,
        ):
            with _one_moment():
                manifest: dict[str, Any] = {"made_at": SYSTEM.now().isoformat(), "rows": counts(), "media": {}}
                for model in kept_models():
                    query = model._default_manager.order_by("pk").iterator(chunk_size=500)
                    serializers.serialize("jsonl", query, use_natural_foreign_keys=True, stream=rows)
                applied = MigrationRecorder(connection).applied_migrations()
                manifest["migrations"] = sorted(f"{app}.{name}" for app, name in applied)
            for name, data in _media(folder, without):
                manifest["media"][name] = hashlib.sha256(data).hexdigest()
                _add(tar, f"media/{name}", data)
            rows.seek(0)
            lines = rows.read().encode()
            manifest["rows_sha256"] = hashlib.sha256(lines).hexdigest()
            _add(tar, "rows.jsonl", lines)
            _add(tar, "manifest.json", json.dumps(manifest, indent=1).encode())
    except OSError as error:
        raise ArchiveError(f"The backup could not be written to {path}: {error.strerror}.") from error
    return manifest


def _add(tar: tarfile.TarFile, name: str, data: bytes) -> None:
    info = tarfile.TarInfo(name)
    info.size, info.mtime = len(data), int(SYSTEM.now().timestamp())
    tar.addfile(info, io.BytesIO(data))
