"""Check the front end and the robots' consoles: types, ESLint, and the formatting by Prettier."""

import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from setup import FRONTEND, ROOT, find_node  # type: ignore[attr-defined]

MODULES = FRONTEND / "node_modules"
CONSOLES = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("robots/**/console") if path.is_dir())
FILES = [
    "frontend/src",
    "frontend/tests",
    *(f"frontend/{n}" for n in ("eslint.config.js", "vite.config.ts")),
    *CONSOLES,
]
SCRIPTS = [f"{name}/**/*.{{ts,js}}" if "." not in name else name for name in FILES]
COMMANDS = (
    (MODULES / "@typescript/native/bin/tsc", "--noEmit", "--project", FRONTEND),
    (
        MODULES / "eslint/bin/eslint.js",
        "--no-error-on-unmatched-pattern",
        "--config",
        FRONTEND / "eslint.config.js",
        *FILES,
    ),
    (
        MODULES / "prettier/bin/prettier.cjs",
        "--check",
        "--no-error-on-unmatched-pattern",
        "--log-level",
        "warn",
        *SCRIPTS,
    ),
)

node = find_node() / "node"
failed = [
    command
    for command in COMMANDS
    if subprocess.run([str(c) for c in (node, *command)], cwd=ROOT, check=False).returncode
]
sys.exit(1 if failed else 0)
