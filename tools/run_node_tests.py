"""Run the front end's unit tests with Node's own test runner."""

import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from setup import FRONTEND, find_node  # type: ignore[attr-defined]

tests = sorted(str(p.relative_to(FRONTEND)) for p in (FRONTEND / "tests").glob("*.test.ts"))
sys.exit(
    subprocess.run(
        [str(find_node() / "node"), "--import", "./tests/published.ts", "--test", *tests], cwd=FRONTEND, check=False
    ).returncode
)
