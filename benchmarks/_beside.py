"""Libraries that only benchmarks use, beside the portal's own or in environments of their own."""

import os
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


def environment(name: str) -> Path:
    """Return an environment with what `requirements/<name>.lock` names, outside the portal's folder; made once."""
    uv, lock = ROOT / ".venv" / "bin" / "uv", ROOT / "requirements" / f"{name}.lock"
    kept = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "farhand" / name
    stamp = kept / "made.from"
    if not stamp.exists() or stamp.read_text() != lock.read_text():
        subprocess.run([uv, "venv", "-q", "--clear", "-p", sys.executable, kept], check=True)
        install = [uv, "pip", "install", "-q", "--system-certs", "--require-hashes", "-p", kept / "bin" / "python"]
        subprocess.run([*install, "-r", lock], check=True)
        stamp.write_text(lock.read_text())
    return kept
