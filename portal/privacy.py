"""What the portal writes is its owner's alone: database, pictures, secrets, backups."""

import contextlib
import os
from pathlib import Path

UMASK = 0o077


def tighten(folder: Path) -> int:
    """Take every right of others from what stands under `folder`; return how many files and folders had one."""
    changed = 0
    for path in [folder, *folder.rglob("*")]:
        if path.is_symlink():
            continue
        with contextlib.suppress(OSError):  # gone meanwhile, or somebody else's
            mode = path.stat().st_mode & 0o777
            if mode & UMASK:
                path.chmod(mode & ~UMASK)
                changed += 1
    return changed


def keep_private(folder: Path) -> None:
    """Make `folder` if it is not there, its owner's alone, and all that this process writes from now on."""
    os.umask(UMASK)
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.suppress(OSError):
        folder.chmod(folder.stat().st_mode & ~UMASK & 0o777)
