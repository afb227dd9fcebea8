"""The places of the portal's files and data, in a clone or installed from a wheel; only their owner may read data.

Secrets of the installation are made here, too.
"""

import base64
import contextlib
import os
import secrets
import sys
from collections.abc import Callable
from pathlib import Path

_PORTAL = Path(__file__).resolve().parent
_SHIPPED = _PORTAL / "shipped"  # a wheel contains templates and front end; the folder around it is shared
ROOT = _PORTAL.parent  # every process imports our packages from here
INSTALLED = _SHIPPED.is_dir()
TEMPLATES_DIR = _SHIPPED / "templates" if INSTALLED else ROOT / "templates"
FRONTEND_DIST = _SHIPPED / "frontend" if INSTALLED else ROOT / "frontend" / "dist"
UMASK = 0o077
P256 = 0xFFFFFFFF00000000FFFFFFFFFFFFFFFFBCE6FAADA7179E84F3B9CAC2FC632551  # the order of the curve: a key is less


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


def kept_secret(path: Path, make: Callable[[], str]) -> str:
    """Return the secret of this installation in the file `path`, made once and readable by its owner only."""
    try:
        return path.read_text().strip()
    except FileNotFoundError:
        pass
    part = path.with_suffix(f".{os.getpid()}")
    descriptor = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    with os.fdopen(descriptor, "w") as file:
        file.write(make())
    with contextlib.suppress(FileExistsError):  # atomic: the first process wins
        os.link(part, path)
    part.unlink()
    return path.read_text().strip()


def new_push_key() -> str:
    """Return a new private key of P-256 in base64url: the portal signs by it what it sends to push services."""
    return base64.urlsafe_b64encode((1 + secrets.randbelow(P256 - 1)).to_bytes(32, "big")).decode().rstrip("=")
