"""Processes that may wait let others go first, also those of other sessions."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from robots.kit.priority import AUTOGROUP
from tests.rig import ROOT

pytestmark = pytest.mark.skipif(not Path(AUTOGROUP).exists(), reason="autogroups of Linux")
SHOWN = """
import os
# What was never in a session, as under an init process, belongs to no group: the file is empty.
group = open("/proc/self/autogroup").read().split() or ["0"]
print(os.getpriority(os.PRIO_PROCESS, 0), group[-1])
"""


def shown(*argv, own):
    done = subprocess.run(
        [sys.executable, *argv], cwd=ROOT, capture_output=True, text=True, check=True, start_new_session=own
    )
    return [int(word) for word in done.stdout.split()]


@pytest.mark.parametrize("own", [True, False])
def test_a_process_that_stands_back_takes_its_session_with_it_if_it_leads_one(own):
    before = shown("-c", SHOWN, own=own)
    process, session = shown("-c", f"from robots.kit.priority import stand_back; stand_back(5)\n{SHOWN}", own=own)
    assert process == before[0] + 5
    assert session == (5 if own else before[1])


@pytest.mark.skipif(os.geteuid() != 0, reason="becomes another user")
def test_an_ordinary_user_s_change_that_comes_too_soon_is_made_again():
    become = (
        "import ctypes, os; os.setuid(65534); ctypes.CDLL(None).prctl(4, 1)"  # its files in /proc are its own again
    )
    change = "print(*[int(share_less(n)) for n in (3, 4, 5)])"
    assert shown("-c", f"from robots.kit.priority import share_less; {become}; {change}\n{SHOWN}", own=True) == [
        1,
        1,
        1,
        0,
        5,
    ]
