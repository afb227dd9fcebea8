"""Check the front end and the robots' consoles: types, ESLint, and the formatting by Prettier."""

import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from setup import FRONTEND, ROOT, find_node  # type: ignore[attr-defined]

MODULES = FRONTEND / "node_modules"
CONSOLES = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("robots/**/console") if path.is_dir())
FILES = ["frontend/src", "frontend/tests", "frontend/eslint.config.js", "frontend/vite.config.ts", *CONSOLES]
SCRIPTS = [f"{name}/**/*.{{ts,js}}" if "." not in name else name for name in FILES]
LENIENT = "--no-error-on-unmatched-pattern"
COMMANDS = (
    (MODULES / "@typescript/native/bin/tsc", "--noEmit", "--project", FRONTEND),
    (MODULES / "eslint/bin/eslint.js", LENIENT, "--config", FRONTEND / "eslint.config.js", *FILES),
    (MODULES / "prettier/bin/prettier.cjs", "--check", LENIENT, "--log-level", "warn", *SCRIPTS),
)

node = find_node() / "node"
results = [subprocess.run([str(c) for c in (node, *command)], cwd=ROOT, check=False) for command in COMMANDS]
sys.exit(any(result.returncode for result in results))
