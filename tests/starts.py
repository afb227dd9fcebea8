"""The settings as a process reads them at its start, for many variables in one process."""

import json
import subprocess
import sys
from pathlib import Path

from tests.waiting import CEILING_S

ROOT = Path(__file__).resolve().parent.parent
READ = """
import json, os, sys, traceback
from django.conf import LazySettings
found, inherited = [], dict(os.environ)
for case in json.loads(sys.argv[2]):
    os.environ.clear()
    os.environ.update(inherited | case)
    sys.modules.pop("portal.settings", None)
    try:
        found.append([str(getattr(LazySettings(), sys.argv[1])), ""])
    except Exception:
        found.append(["", traceback.format_exc()])
print(json.dumps(found))
"""


def read(name: str, cases: list[dict[str, str]], env: dict[str, str]) -> list[tuple[str, str]]:
    """Return for each case what the setting is, and the traceback with which a start ends; one of them is empty."""
    done = subprocess.run(
        [sys.executable, "-c", READ, name, json.dumps(cases)], cwd=ROOT, capture_output=True, text=True, check=True,
        env={**env, "DJANGO_SETTINGS_MODULE": "portal.settings"}, timeout=CEILING_S,
    )  # fmt: skip
    return [(value, error) for value, error in json.loads(done.stdout.splitlines()[-1])]
