"""Previews that strangers ask for never delay a command, a stop or presence."""

import json
import os
import signal
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

from portal.live.previews import EACH_S
from robots.kit.arms.described import posture
from robots.kit.description import load
from tests.conftest import wait_for
from tests.faults.here import heard, line

# ruff: noqa: TID251 - its tests are timed
pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["pa10"], indirect=True)]
READY = list(map(float, posture(load("pa10"), "ready")))
PATH = "/ws/robots/pa10/"


def ask(one, n, kind="ready", **args):
    one.send(json.dumps({"t": "plan", "n": n, "kind": kind, "args": args, "from": READY}))


def count(web):
    from portal.live.loop import of_loop

    return web.ask(lambda: of_loop().previews.computed)


def child(web):
    from portal.live.loop import of_loop

    return web.ask(lambda: of_loop().previews._process and of_loop().previews._process.pid)


def busy():
    from portal.live.loop import of_loop

    return of_loop().previews.computing


@pytest.mark.asvs("2.4.1", "15.2.2")
def test_a_cleared_person_is_answered_and_nobody_else(web, people):
    with line(web, people["ada"], PATH) as ada, line(web, people["eve"], PATH) as eve, line(web, path=PATH) as nobody:
        for one in (ada, eve, nobody):
            heard(one, "snapshot")
            ask(one, 5)
        assert heard(ada, "plan", 40)["ok"]
        said = heard(eve, "plan")
        assert (said["n"], said["ok"]) == (5, False)
        assert "clearance test" in said["text"]
        assert "Sign in" in heard(nobody, "plan")["text"]
        assert count(web) == 1
    web.nothing_left()


@pytest.mark.asvs("2.4.1", "15.2.2")
def test_one_person_has_one_share_however_many_sockets(web, people):
    """Of ten sockets at their limits the newest question alone is computed, and another person comes next."""
    with ExitStack() as stack, line(web, people["bob"], PATH) as bob:
        sockets = [stack.enter_context(line(web, people["ada"], PATH)) for _ in range(10)]
        for one in [*sockets, bob]:
            heard(one, "snapshot")
        ask(bob, 1)
        heard(bob, "plan", 40)
        before, begun = count(web), time.monotonic()
        for n in range(1, 26):
            for one in sockets:
                ask(one, n)
        ask(bob, 2)
        assert heard(bob, "plan")["n"] == 2
        for one in sockets:  # which of her sockets is read last is the server's choice
            one.send(json.dumps({"t": "ping", "n": 1}))
            heard(one, "pong")
        ask(sockets[-1], 26)
        wait_for(lambda: heard(sockets[-1], "plan", 20)["n"] == 26, 20, "ada's newest")
        # of 251, with those that were computed while the rest came in
        assert count(web) - before < 3 + (time.monotonic() - begun) / EACH_S
    web.nothing_left()


def test_a_preview_that_dies_or_hangs_is_answered_and_the_next_one_computed(web, people, monkeypatch):
    monkeypatch.setattr("portal.live.previews.OVERRUN_S", 60.0)
    with line(web, people["ada"], PATH) as ada, line(web, people["bob"], PATH) as bob:
        heard(ada, "snapshot")
        heard(bob, "snapshot")
        ask(bob, 1)
        assert heard(bob, "plan", 40)["ok"]
        os.kill(child(web), signal.SIGSTOP)
        ask(ada, 2)
        wait_for(lambda: web.ask(busy), 5, "its being computed")
        os.kill(child(web), signal.SIGKILL)
        assert not heard(ada, "plan")["ok"]
        ask(bob, 3)
        assert heard(bob, "plan", 40)["ok"]
        ask(ada, 4)
        assert not heard(ada, "plan")["ok"]  # a person whose preview was cut off rests a moment
    web.nothing_left()


def test_the_process_ends_when_nobody_asks(web, people, monkeypatch):
    monkeypatch.setattr("portal.live.previews.IDLE_S", 0.5)
    with line(web, people["ada"], PATH) as ada:
        heard(ada, "snapshot")
        assert child(web) is None
        ask(ada, 1)
        assert heard(ada, "plan", 40)["ok"]
        pid = child(web)
        wait_for(lambda: child(web) is None, 5, "the end of the process")
        wait_for(lambda: not Path(f"/proc/{pid}").exists(), 5, "its end in the process table")
        ask(ada, 2)
        assert heard(ada, "plan", 40)["ok"]
