"""Makes the portal's files readable by their owner only: database, pictures, secrets, backups."""

import contextlib
import os
from pathlib import Path

UMASK = 0o077


def tighten(folder: Path) -> int:
    """Remove all rights of others from files under `folder`. Return how many had any."""
    changed = 0
    for path in [folder, *folder.rglob("*")]:
        if path.is_symlink():
            continue
        with contextlib.suppress(OSError):  # deleted meanwhile, or owned by another user
            mode = path.stat().st_mode & 0o777
            if mode & UMASK:
                path.chmod(mode & ~UMASK)
                changed += 1
    return changed


def keep_private(folder: Path) -> None:
    """Create `folder` if needed; make it and all files that this process writes from now on private."""
    os.umask(UMASK)
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.suppress(OSError):
        folder.chmod(folder.stat().st_mode & ~UMASK & 0o777)
