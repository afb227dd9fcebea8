"""Forks of the process that has loaded everything are what `python -m` would have started."""

import ast
import os
import re
import signal
import subprocess
import sys

import pytest

from tests.conftest import at_length
from tests.rig import ROOT, Child

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks are made on Linux only")
ROLES = ("web", "owner", "housekeeping", "recorder")
SHOW = ("-m", "django", "diffsettings", "--all")
IN_FORKS = """
import asyncio, json, os, sys, tempfile
from pathlib import Path
from portal import forks

async def main():
    told = {}
    for role in sys.argv[1:]:
        argv = (sys.executable, "-m", "django", "diffsettings", "--all")
        with tempfile.TemporaryFile() as out:
            fork = await forks.fork(role, argv, {**os.environ, "FARHAND_ROLE": role}, Path.cwd(), out.fileno())
            if fork is None:
                sys.exit("no fork")
            await fork.wait()
            told[role] = os.pread(out.fileno(), 1_000_000, 0).decode()
    other = {**os.environ, "FARHAND_TURN_S": "7"}
    told["other"] = await forks.fork("other", argv, other, Path.cwd(), 1)
    print(told)

forks.prepare()
asyncio.run(main())
"""
BEYOND = """
import ctypes, os, sys
from portal import forks, gaps

libc = ctypes.CDLL(None)
libc.malloc.restype = libc.sbrk.restype = ctypes.c_void_p
libc.malloc.argtypes, libc.sbrk.argtypes = [ctypes.c_size_t], [ctypes.c_ssize_t]
fill, gaps.fill = gaps.fill, lambda: None
forks.load_all()
libc.free.argtypes = [ctypes.c_void_p]
gaps_made = [(libc.malloc(size), libc.malloc(24)) for size in range(600, 20000, 20)]
for gap, _ in gaps_made:  # what lies between two of these is kept, so that each stays a gap of its own
    libc.free(gap)
if sys.argv[1] == "filled":
    fill()
libc.malloc_trim(0)
end = libc.sbrk(0)
print(sum(libc.malloc(size) < end for size in range(600, 20000, 20)))
"""


def _python(environment, *argv):
    done = subprocess.run(
        [sys.executable, *argv], env=environment, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return re.sub(r"0x[0-9a-f]+", "0x", done.stdout)


@pytest.fixture
def environment(tmp_path):
    plain = {k: v for k, v in os.environ.items() if not k.startswith(("FARHAND_", "DJANGO_", "DATABASE_URL"))}
    return {**plain, "DJANGO_SETTINGS_MODULE": "portal.settings", "FARHAND_VAR": str(tmp_path), "PYTHONHASHSEED": "0"}


@pytest.mark.parametrize("compared", [("owner", "housekeeping"), at_length(ROLES)], ids=["some", "all"])
def test_a_fork_has_the_settings_of_its_role_and_other_settings_need_a_new_process(environment, compared):
    told = ast.literal_eval(_python(environment, "-c", IN_FORKS, *ROLES))
    assert told.pop("other") is None
    for role in compared:  # with a process that was started in the ordinary way
        assert told[role] == _python({**environment, "FARHAND_ROLE": role}, *SHOW)
    assert "'timeout': 2," in told["owner"] or "'timeout': 2}" in told["owner"]
    assert told["web"] != told["owner"] != told["housekeeping"]


def test_what_is_allocated_after_the_fork_lies_on_pages_of_its_own(environment):
    """Of 970 blocks, how many lie between what was loaded before."""
    without, filled = (int(_python(environment, "-c", BEYOND, how)) for how in ("as it is", "filled"))
    assert filled < 50 < 500 < without


def test_a_process_that_is_killed_in_its_first_moment_ends():
    """Before it has a group of its own; who waited for it waited for ever."""
    for _ in range(20):
        child = Child("killed", [sys.executable, "-m", "http.server", "0"])
        child.signal(signal.SIGKILL)
        assert child.process.wait(20) == -signal.SIGKILL
