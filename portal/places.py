"""Where the portal's files and its data are: in a clone, and installed from a wheel."""

import os
import sys
from pathlib import Path

_PORTAL = Path(__file__).resolve().parent
_SHIPPED = _PORTAL / "shipped"  # a wheel contains templates and front end; the folder around it is shared
ROOT = _PORTAL.parent  # every process imports our packages from here
INSTALLED = _SHIPPED.is_dir()
TEMPLATES_DIR = _SHIPPED / "templates" if INSTALLED else ROOT / "templates"
FRONTEND_DIST = _SHIPPED / "frontend" if INSTALLED else ROOT / "frontend" / "dist"


def default_var() -> Path:
    """Return the data folder unless `FARHAND_VAR` names one: `var/` of a clone, or the user's data folder.

    It does not depend on the working folder, because a stop that is stored there must be found again.
    """
    if not INSTALLED:
        return ROOT / "var"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "farhand"
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "farhand"
