"""RANGE ERROR: how the arm comes into it, and the one way out."""

import threading
import time

import numpy as np
import pytest

from robots.kit.arms.described import chain
from robots.kit.contract.errors import HardwareFault, OutOfWorkspace
from tests.conftest import wait_for
from tests.drivers.pa10_wire import Terminal, allow, do, journal, push_out

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


def test_pushed_into_a_box_it_stops_and_only_the_default_position_leads_out(arm, shared):
    do(arm, "joints", **dict(zip(chain("pa10").names, np.radians([150, -40, -40, 0, -30, 0]), strict=True)))

    def push():
        wait_for(lambda: shared.status()["q"][0] < np.radians(147), 20, "the motion")
        shared.fault("disturb", 3000.0)

    thread = threading.Thread(target=push)
    thread.start()
    with pytest.raises(HardwareFault, match="Range error"):
        back = dict(zip(chain("pa10").names, np.radians([100, -40, -40, 0, -30, 0]), strict=True))
        do(arm, "joints", **back, speed=0.1)  # slowly: it is pushed on its way
    thread.join()
    shared.clear()
    assert journal(shared, "range_error")
    assert not arm.state().ready
    with pytest.raises((HardwareFault, OutOfWorkspace), match="only j 0 0 0 0 0 0"):
        do(arm, "ready")
    assert arm.recover(allow).ready


def test_pushed_out_at_rest_it_says_so(terminal, shared):
    push_out(terminal, shared)
    assert "S1" in journal(shared, "range_error")[-1]["why"]
    for line in ("j 0 25 75 0 80 0", "g 1", "p 1", "J 0 0 0 0 0 1"):
        assert terminal.ask(line).startswith("e range"), line


def test_neither_silence_nor_a_restart_leads_out_of_it(terminal, shared):
    push_out(terminal, shared)
    boot = shared.status()["boot"]
    shared.fault("restart", count=1)
    wait_for(lambda: shared.status()["boot"] > boot, 10, "the restart")
    other = Terminal(shared)
    other.ask(f"i {time.monotonic_ns()}")
    assert other.ask("w") == "e"
    assert other.ask("j 0 25 75 0 80 0").startswith("e range")
    assert other.ask("j 0 0 0 0 0 0").startswith("ok")
    assert other.ask("W") == "a"
    other.close()


def test_the_way_out_must_be_gone_to_its_end(terminal, shared):
    push_out(terminal, shared)
    assert terminal.ask("j 0 0 0 0 0 0 0.2").startswith("ok")
    assert terminal.ask("j 0 25 75 0 80 0").startswith("e "), "another target does not take its place"
    wait_for(lambda: shared.status()["moving"], 5, "the motion")
    assert terminal.ask("h") == "ok hold"
    assert terminal.ask("W") == "e", "held on its way out, it is not out"
    assert terminal.ask("j 0 0 0 0 0 0").startswith("ok")
    assert terminal.ask("W") == "a"
    assert terminal.ask("j 0 25 75 0 80 0").startswith("ok")


def test_a_target_that_cannot_be_is_refused_and_is_no_range_error(terminal, shared):
    for line in ("j 200 0 0 0 0 0", "k 1900 0 100 180 0 180", "k 500 0 -50 180 0 180"):
        assert terminal.ask(line).startswith(("e range", "e box")), line
        assert terminal.ask("w") == "a"
