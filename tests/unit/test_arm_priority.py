"""The requests of the arm's control loop to the system's scheduler, each in a process of its own."""

import os
import platform
import subprocess
import sys

import pytest

ASK = "import os; from simulators.common.arm.priority import {0}; print({0}(), os.sched_getscheduler(0) & 0xFF, os.nice(0))"


def asked(what, *before):
    done = subprocess.run([*before, sys.executable, "-c", ASK.format(what)], capture_output=True, text=True, check=True)
    return done.stdout.split()


@pytest.mark.skipif(platform.system() != "Linux", reason="a call of Linux")
def test_short_turns_change_neither_policy_nor_niceness():
    assert asked("short_turns", "nice", "-n", "3") in (["True", "0", "3"], ["False", "0", "3"])


@pytest.mark.skipif(platform.system() != "Linux", reason="priorities of Linux")
def test_without_the_right_the_benchmark_of_an_ordinary_user_gets_no_real_time_priority():
    *how, policy, _ = asked("first_in_line", sys.executable, "-m", "benchmarks._ordinary")
    assert " ".join(how) in ("short turns", "none")
    assert int(policy) not in (os.SCHED_RR, os.SCHED_FIFO)


def test_whatever_is_allowed_is_taken_and_nothing_is_raised():
    how = " ".join(asked("first_in_line"))
    assert how.startswith(("real time 2", "short turns 0", "none 0"))
