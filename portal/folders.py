"""The places of the portal's files and data, in a clone or installed from a wheel; only their owner may read data."""

import contextlib
import os
import sys
from pathlib import Path

_PORTAL = Path(__file__).resolve().parent
_SHIPPED = _PORTAL / "shipped"  # a wheel contains templates and front end; the folder around it is shared
ROOT = _PORTAL.parent  # every process imports our packages from here
INSTALLED = _SHIPPED.is_dir()
TEMPLATES_DIR = _SHIPPED / "templates" if INSTALLED else ROOT / "templates"
FRONTEND_DIST = _SHIPPED / "frontend" if INSTALLED else ROOT / "frontend" / "dist"
UMASK = 0o077


def default_var() -> Path:
    """Return the data folder unless `FARHAND_VAR` names one: `var/` of a clone, or the user's data folder.

    It does not depend on the working folder, because a stop that is stored there must be found again.
    """
    if not INSTALLED:
        return ROOT / "var"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "farhand"
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "farhand"


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
