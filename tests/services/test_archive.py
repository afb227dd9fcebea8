"""Backups and restoring: private files, no name that leaves its folder, all or nothing."""

import io
import json
import os
import stat
import subprocess
import sys
import tarfile

import pytest
from django.db import OperationalError, connection

from portal import folders
from portal.keep import archive
from portal.keep import restore as restoring
from robots.models import Robot
from tests.environment import ROOT

pytestmark = pytest.mark.django_db(transaction=True)
SINCE = ("robots.0018_settings", "robots.0019_settings_alone")


@pytest.fixture
def media(settings, tmp_path):
    settings.MEDIA_ROOT = tmp_path / "media"
    folder = settings.MEDIA_ROOT / "frames" / "mercury"
    folder.mkdir(parents=True)
    (folder / "a.jpg").write_bytes(b"a picture")
    return settings.MEDIA_ROOT


@pytest.fixture
def backup(robot, people, media, tmp_path):
    archive.write(tmp_path / "backup.tar.gz")
    return tmp_path / "backup.tar.gz"


def everything(media):
    return archive.counts(), archive.media_hashes(media), list(Robot.objects.values_list("name", "cycle"))


def changed(backup, change, extra=()):
    """Write the archive anew with one file changed, or with members beside."""
    target = backup.with_name("changed.tar.gz")
    with tarfile.open(backup) as old, tarfile.open(target, "w:gz") as new:
        for member in old:
            data = change(member.name, old.extractfile(member).read())
            if data is not None:
                info = tarfile.TarInfo(member.name)
                info.size = len(data)
                new.addfile(info, io.BytesIO(data))
        for info, data in extra:
            info.size = len(data)
            new.addfile(info, io.BytesIO(data))
    return target


def same(name, data):
    return data


def of_an_older_version(name, data):
    """Return a file of a backup from before a robot's settings were declared by its spec."""
    if name == "manifest.json":
        told = json.loads(data)
        told["migrations"] = [one for one in told["migrations"] if one not in SINCE]
        del told["rows_sha256"]
        return json.dumps(told).encode()
    if name != "rows.jsonl":
        return data
    rows = [json.loads(line) for line in data.splitlines()]
    for row in rows:
        if row["model"] == "robots.robot":
            del row["fields"]["settings"]
            row["fields"] |= {"speed": 0.2, "boxes": [], "stability_threshold": None, "delivery_exposure_s": 0.01}
    return b"".join(json.dumps(row).encode() + b"\n" for row in rows)


@pytest.mark.service
def test_settings_of_an_older_backup_are_restored(backup, media):
    restoring.read(changed(backup, of_an_older_version), replace=True)
    assert Robot.objects.get().settings == {"speed": 0.2, "still_exposure_s": 0.01}


@pytest.mark.service
def test_settings_are_restored(robot, people, media, tmp_path):
    Robot.objects.update(settings={"speed": 0.25})
    archive.write(tmp_path / "with.tar.gz")
    Robot.objects.update(settings={})
    restoring.read(tmp_path / "with.tar.gz", replace=True)
    assert Robot.objects.get().settings == {"speed": 0.25}


def manifest_with(**more):
    def change(name, data):
        if name != "manifest.json":
            return data
        manifest = json.loads(data)
        return json.dumps({k: {**manifest[k], **more[k]} if k in more else v for k, v in manifest.items()}).encode()

    return change


def special(name, kind, to=""):
    info = tarfile.TarInfo(name)
    info.type, info.linkname = kind, to
    return [(info, b"")]


BROKEN = {
    "absolute": (same, [(tarfile.TarInfo("/tmp/escaped"), b"x")]),
    "upwards": (same, [(tarfile.TarInfo("media/../../escaped"), b"x")]),
    "hidden": (same, [(tarfile.TarInfo("media/.before-restoring/x"), b"x")]),
    "elsewhere": (same, [(tarfile.TarInfo("escaped"), b"x")]),
    "a link": (same, special("media/link", tarfile.SYMTYPE, "/etc")),
    "a hard link": (same, special("media/link", tarfile.LNKTYPE, "/etc/passwd")),
    "a device": (same, special("media/null", tarfile.CHRTYPE)),
    "a name in the list": (manifest_with(media={"../../escaped": "0" * 64}), []),
    "a picture changed": (lambda n, d: b"another" if n.endswith(".jpg") else d, []),
    "a picture missing": (lambda n, d: None if n.endswith(".jpg") else d, []),
    "a picture too many": (same, [(tarfile.TarInfo("media/frames/b.jpg"), b"x")]),
    "rows too few": (manifest_with(rows={"robots.robot": 7}), []),
    "rows cut": (lambda n, d: d[: len(d) // 2] if n == "rows.jsonl" else d, []),
    "rows that clash": (lambda n, d: d + d.splitlines(True)[-1].replace(b'"pk": ', b'"pk": 9') if n == "rows.jsonl" else d, []),
    "a row changed": (lambda n, d: d.replace(b"Mercury", b"Mallory") if n == "rows.jsonl" else d, []),
    "no rows": (lambda n, d: None if n == "rows.jsonl" else d, []),
    "no list": (lambda n, d: None if n == "manifest.json" else d, []),
    "a list that is none": (lambda n, d: b"[1]" if n == "manifest.json" else d, []),
}  # fmt: skip


@pytest.mark.service
@pytest.mark.asvs("5.3.2")
@pytest.mark.parametrize("how", BROKEN)
def test_a_broken_backup_changes_nothing(backup, media, how, tmp_path):
    Robot.objects.update(name="As it is now")
    (media / "frames" / "now.jpg").write_bytes(b"now")
    before = everything(media)
    with pytest.raises(archive.ArchiveError):
        restoring.read(changed(backup, *BROKEN[how]), replace=True)
    assert everything(media) == before
    assert not list(tmp_path.rglob("escaped"))
    assert {p.name for p in media.iterdir()} == {"frames"}


@pytest.mark.service
@pytest.mark.asvs("5.3.2")
def test_a_backup_cut_off_changes_nothing(backup, media):
    Robot.objects.update(name="As it is now")
    before = everything(media)
    whole = backup.read_bytes()
    for part in (0, 10, len(whole) // 2, len(whole) * 9 // 10):
        backup.write_bytes(whole[:part])
        with pytest.raises(archive.ArchiveError):
            restoring.read(backup, replace=True)
        assert everything(media) == before


@pytest.mark.service
def test_restoring_brings_rows_and_pictures_back(backup, media):
    rows, hashes, _ = everything(media)
    Robot.objects.update(name="As it is now")
    (media / "frames" / "mercury" / "a.jpg").write_bytes(b"painted over")
    with pytest.raises(archive.ArchiveError, match="not empty"):
        restoring.read(backup)
    restoring.read(backup, replace=True)
    assert everything(media)[:2] == (rows, hashes)
    assert Robot.objects.get().name == "Mercury"
    assert Robot.objects.get().stop_latched, "the backup knows of no stop that came after it"
    assert {p.name for p in media.iterdir()} == {"frames"}


@pytest.mark.service
@pytest.mark.django_db(transaction=True)
def test_a_commit_that_fails_puts_rows_and_pictures_back(backup, media, monkeypatch):
    (media / "frames" / "mercury" / "later.jpg").write_bytes(b"taken after the backup")
    before, pictures = everything(media), []

    def fail():
        pictures.append(sorted(p.name for p in (media / "frames" / "mercury").iterdir()))
        raise OperationalError("disk I/O error")

    monkeypatch.setattr(connection, "commit", fail)
    with pytest.raises(archive.ArchiveError, match="nothing was changed"):
        restoring.read(backup, replace=True)
    monkeypatch.undo()
    assert pictures == [["a.jpg"]], "the pictures are swapped before the rows are committed"
    assert everything(media) == before


@pytest.mark.service
def test_a_swap_that_was_killed_is_undone_by_the_next(backup, media):
    (media / restoring.OLD).mkdir()
    (media / "frames").rename(media / restoring.OLD / "frames")
    (media / "frames").mkdir()
    backup.write_bytes(b"none")
    with pytest.raises(archive.ArchiveError):
        restoring.read(backup)
    assert (media / "frames" / "mercury" / "a.jpg").read_bytes() == b"a picture"


def others(path):
    return stat.S_IMODE(path.stat().st_mode) & 0o077


@pytest.mark.asvs("13.3.1")
def test_backups_are_for_their_owner_alone(backup):
    assert others(backup) == 0


@pytest.mark.asvs("13.3.1")
def test_existing_files_are_tightened_and_links_are_left(tmp_path):
    outside = tmp_path / "outside"
    outside.write_text("x")
    outside.chmod(0o644)
    var = tmp_path / "var"
    (var / "media").mkdir(parents=True)
    (var / "db").write_text("x")
    (var / "db").chmod(0o666)
    (var / "link").symlink_to(outside)
    var.chmod(0o755)
    assert folders.tighten(var) >= 2
    assert (others(var), others(var / "db"), others(outside)) == (0, 0, 0o044)


@pytest.mark.asvs("13.3.1")
def test_a_process_of_the_portal_writes_for_its_owner_alone(tmp_path):
    var = tmp_path / "var"
    var.mkdir(mode=0o755)
    env = {**os.environ, "FARHAND_VAR": str(var), "DATABASE_URL": f"sqlite:///{var}/db.sqlite3", "SECRET_KEY": ""}
    subprocess.run(
        [sys.executable, "manage.py", "migrate", "robots", "-v0"], cwd=ROOT, env=env, check=True, umask=0o022
    )
    assert (var / "db.sqlite3").exists()
    assert {str(p): oct(others(p)) for p in [var, *var.rglob("*")] if others(p)} == {}
