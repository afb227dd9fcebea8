"""Who may drive the museum arm: epochs, token, watchdog.

Watchdogs are tried in real time: what they judge is how late a process, a thread or the network may be.
"""

import time

import pytest

from robots.kit.contract.errors import LineBusy, LineGone
from robots.kit.drivers.pa10.checks import planner_for, request_of
from robots.kit.drivers.pa10.driver import Driver
from tests.conftest import wait_for
from tests.drivers.pa10_wire import FASTER, Terminal, allow, do, journal
from tests.rig import ArmSimulator

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


@pytest.fixture
def started(tmp_path):
    """Start a simulator of the test's own, which is stopped at the end."""
    made = []

    def start(**options):
        made.append(ArmSimulator(tmp_path, **options))
        return made[-1]

    yield start
    for sim in made:
        sim.stop()


def test_one_client_and_a_newer_epoch_takes_over(arm, shared):
    other = Terminal(shared)
    assert "another client is connected" in other.ask("w")
    stale = Terminal(shared)
    assert "is over" in stale.ask("i 1")
    newer = Driver(str(shared.folder / "tty"), {"epoch": time.monotonic_ns()})
    newer.connect()
    before = len(journal(shared, "motion"))
    with pytest.raises(LineGone):
        do(arm, "home")
    with pytest.raises(LineBusy, match="is over"):
        arm.connect()
    assert len(journal(shared, "motion")) == before
    newer.close()


def test_the_watchdog_starts_the_application_again(started, tmp_path):
    sim = started(watchdog=2.0, nobody=6.0)
    driver = Driver(str(tmp_path / "tty"), {"epoch": 1})
    driver.connect()
    for _ in range(6):  # an idle arm whose owner asks is left alone
        time.sleep(0.3)
        assert driver.state().ready
    before = sim.status()["boot"]  # a slow start may have waited for somebody more than once
    driver.line.ask(request_of("ready", {}))
    wait_for(lambda: sim.status()["boot"] > before, 20, "the end of an owner that is silent in mid-motion")
    assert sim.status()["boot"] == before + 1
    assert any("no line for 2 s" in r["why"] for r in journal(sim, "application"))
    assert not sim.status()["moving"]
    with pytest.raises(LineGone):
        driver.state()
    wait_for(lambda: any("nobody connected" in r["why"] for r in journal(sim, "application")), 12, "nobody")
    driver.connect()
    assert driver.recover(allow).ready
    driver.close()


def test_a_controller_that_wants_a_token(started, tmp_path, monkeypatch):
    monkeypatch.setenv("PA10_TOKEN", "open-sesame")
    sim = started()
    for settings in ({"epoch": 1}, {"epoch": 1, "token": "guess"}):
        with pytest.raises(LineBusy, match="token"):
            Driver(str(tmp_path / "tty"), settings).connect()
    good = Driver(str(tmp_path / "tty"), {"epoch": 1, "token": "open-sesame"})
    assert good.connect().ready
    good.close()
    assert len(journal(sim, "refused")) == 2


def test_an_absurd_epoch_locks_nobody_out(started, tmp_path):
    """Without a token anybody may claim; the claim ends with the minute in which nobody is connected."""
    sim = started(watchdog=2.0, nobody=2.0)
    stranger = Terminal(sim)
    assert stranger.ask("i 1e308").startswith("e range")
    assert stranger.ask("i 9007199254740991").startswith("ok epoch")
    planner_for({})  # made now, because the first driver of a process takes long for it
    at = time.monotonic()
    stranger.close()
    driver = Driver(str(tmp_path / "tty"), {"epoch": 7})
    with pytest.raises(LineBusy, match="is over"):
        driver.connect()
    wait_for(lambda: any("nobody" in r["why"] for r in journal(sim, "application", at)), 10, "nobody")
    assert driver.connect().ready
    driver.close()


def test_who_types_is_never_silent_and_an_owner_takes_the_place(started, tmp_path):
    sim = started(watchdog=1.0, nobody=60.0)
    typist = Terminal(sim)
    assert typist.ask("w") == "a"
    for half in (b"j 10 25", b" 75 0 80", b" 0\n"):
        time.sleep(1.2)
        typist.socket.sendall(half)
    assert typist.hear().startswith("ok"), "somebody who types slowly is not cut off"
    owner, came = Driver(str(tmp_path / "tty"), {"epoch": 3}), time.monotonic()
    assert owner.connect().ready
    assert typist.hear() == "", "the owner takes the place of somebody who types"
    begun = [(r["t"] < came, r["why"]) for r in journal(sim, "application")]
    assert begun[0] == (True, "power on")
    assert set(begun[1:]) <= {(False, "no line for 1 s")}, "an owner may be silent, where the machine stalls"
    owner.close()


def test_an_owner_who_waits_for_rest_is_not_silent(started):
    sim = started(watchdog=8.0, nobody=60.0, speed=FASTER)
    owner = Terminal(sim)
    owner.ask("i 1")
    owner.ask("j 60 25 75 0 80 0 0.1")  # it takes longer than an owner may be silent
    assert owner.ask("W") == "a"
    assert sim.status()["boot"] == 1
    owner.close()


def test_a_fresh_connection_is_not_dropped_for_the_silence_before_it(started):
    """Nobody was there for longer than an owner may be silent: each one who comes is fresh all the same."""
    sim = started(watchdog=1.5, nobody=60.0)
    for epoch in range(1, 7):
        time.sleep(1.7)
        owner = Terminal(sim)
        assert owner.ask(f"i {epoch}").startswith("ok epoch"), epoch
        assert owner.ask("w") == "a", epoch
        owner.close()
    assert sim.status()["boot"] == 1


def test_idle_connections_keep_nobody_out(shared):
    strangers = [Terminal(shared) for _ in range(60)]
    terminal = Terminal(shared)
    assert terminal.ask(f"i {time.monotonic_ns()}").startswith("ok epoch")
    wait_for(lambda: len(shared.status()["threads"]) < 50, 10, "the end of those that had to go")
    for one in (*strangers, terminal):
        one.close()
