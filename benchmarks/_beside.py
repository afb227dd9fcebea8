"""Libraries that only benchmarks use, beside the portal's own."""

import subprocess
import sys
from importlib import invalidate_caches
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KEPT = ROOT / "var" / "bench"


def needed(*packages: str) -> None:
    """Make the packages importable; install all of `requirements/bench.lock` into var/bench where one is missing."""
    sys.path.append(str(KEPT))
    if any(find_spec(package) is None for package in packages):
        uv, lock = ROOT / ".venv" / "bin" / "uv", ROOT / "requirements" / "bench.lock"
        subprocess.run(
            [uv, "pip", "install", "-q", "--system-certs", "--no-deps", "--target", KEPT, "-r", lock], check=True
        )
        invalidate_caches()
