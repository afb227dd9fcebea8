"""Forks of the process that has loaded everything are what `python -m` would have started."""

import ast
import os
import re
import subprocess
import sys

import pytest

from tests.conftest import at_length
from tests.rig import ROOT

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks are made on Linux only")
ROLES = ("web", "owner", "housekeeping", "recorder")
SHOW = ("-m", "django", "diffsettings", "--all")
IN_FORKS = """
import asyncio, json, os, sys, tempfile
from pathlib import Path
from portal.run import forks

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
FAILS = """
import asyncio, os, sys
from pathlib import Path
from portal.run import forks

fork, forked = os.fork, 0

def some():
    global forked
    forked += 1
    if forked == 3:  # the fork of the first process in between, and the second process in between
        raise BlockingIOError(11, "Resource temporarily unavailable")
    return fork()

async def main():
    argv = (sys.executable, "-m", "this")
    for _ in range(4):
        made = await forks.fork("this", argv, dict(os.environ), Path.cwd(), os.open(os.devnull, os.O_WRONLY))
        print("none" if made is None else await made.wait())

forks.load_all = lambda: None
os.fork = some
forks.prepare()
asyncio.run(main())
"""
STANDS_STILL = """
import asyncio, os, signal, sys, time
from pathlib import Path
from portal.run import forks

async def main():
    argv = (sys.executable, "-m", "this")
    for _ in range(2):
        print(await forks.fork("this", argv, dict(os.environ), Path.cwd(), 1))

forks.load_all = lambda: None
forks.ANSWER_S = 0.5
forks.prepare()
(child,) = map(int, Path(f"/proc/self/task/{os.getpid()}/children").read_text().split())
os.kill(child, signal.SIGSTOP)
asyncio.run(main())
os.kill(child, signal.SIGCONT)
os.waitpid(child, 0)
while True:  # what it forked then has ended, too
    try:
        os.waitpid(-1, 0)
    except ChildProcessError:
        break
"""
DEMO = """
import asyncio, os, sys
from pathlib import Path
from django.core import management
from portal import command
from portal.run import forks

def run(arguments):
    from django.conf import settings

    argv = (sys.executable, "-m", "this")
    made = asyncio.run(forks.fork("this", argv, dict(os.environ), Path.cwd(), os.open(os.devnull, os.O_WRONLY)))
    print("none" if made is None else "fork", settings.SITE_ADDRESS)

management.execute_from_command_line = run
command.main()
"""
BEYOND = """
import ctypes, os, sys
from portal.run import forks, gaps

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


@pytest.mark.timed
@pytest.mark.parametrize("compared", [("owner", "housekeeping"), at_length(ROLES)], ids=["some", "all"])
def test_a_fork_has_the_settings_of_its_role_and_other_settings_need_a_new_process(environment, compared):
    told = ast.literal_eval(_python(environment, "-c", IN_FORKS, *ROLES))
    assert told.pop("other") is None
    for role in compared:  # with a process that was started in the ordinary way
        assert told[role] == _python({**environment, "FARHAND_ROLE": role}, *SHOW)
    assert "'timeout': 2," in told["owner"] or "'timeout': 2}" in told["owner"]
    assert told["web"] != told["owner"] != told["housekeeping"]


@pytest.mark.timed
def test_what_is_allocated_after_the_fork_lies_on_pages_of_its_own(environment):
    """Of 970 blocks, how many lie between what was loaded before."""
    without, filled = (int(_python(environment, "-c", BEYOND, how)) for how in ("as it is", "filled"))
    assert filled < 50 < 500 < without


def test_what_cannot_be_forked_now_is_started_in_the_ordinary_way_and_the_next_is_forked_again(environment):
    assert _python(environment, "-c", FAILS).split() == ["none", "none", "0", "0"]


def test_a_process_that_forks_and_stands_still_is_left_and_starts_nothing_twice(environment):
    assert _python(environment, "-c", STANDS_STILL).split() == ["None", "None"]


def test_the_demo_forks_on_any_port_and_mails_link_to_it(environment):
    assert _python(environment, "-c", DEMO, "demo", "--port", "8123").split() == ["fork", "http://localhost:8123"]
    assert _python(environment, "-c", DEMO, "demo").split() == ["fork", "http://localhost:8000"]


def test_what_is_loaded_beforehand_contains_no_module_that_a_process_runs():
    runs = "import sys; from portal.run import forks; forks.load_all(); print('portal.run.serve' in sys.modules)"
    shown = subprocess.run([sys.executable, "-c", runs], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert shown.stdout.split()[-1:] == ["False"], shown.stderr
