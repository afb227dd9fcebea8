"""Where the portal's own files lie, and where it keeps its data: in a clone, and installed from a wheel."""

import os
import sys
from pathlib import Path

_PORTAL = Path(__file__).resolve().parent
_SHIPPED = _PORTAL / "shipped"  # a wheel has templates and front end inside, for what lies beside it is everybody's
ROOT = _PORTAL.parent  # from here every process of ours finds our packages
INSTALLED = _SHIPPED.is_dir()
TEMPLATES_DIR = _SHIPPED / "templates" if INSTALLED else ROOT / "templates"
FRONTEND_DIST = _SHIPPED / "frontend" if INSTALLED else ROOT / "frontend" / "dist"


def default_var() -> Path:
    """Return where data is kept unless `FARHAND_VAR` says otherwise: `var/` of a clone, else the user's data folder.

    It does not depend on the working folder: a stop that is remembered there must be found again.
    """
    if not INSTALLED:
        return ROOT / "var"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "farhand"
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "farhand"
