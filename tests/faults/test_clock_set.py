"""The whole demo while the time of day is set, in both directions: libraries too keep time by clocks that are not.

libfaketime gives all its processes, Redis among them, another time of day than the machine's; clocks that count the
time since the start stay as they are.
"""

import contextlib
import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import pytest
from websockets.sync.client import connect

from tests.conftest import wait_for
from tests.rig import ROOT, free_port
from tests.waiting import CEILING_S

HERE = Path(__file__).parent / "set_clock"
LIBRARY = next(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"), None)
HOUR, YEAR = 3600, 31_557_600
AHEAD_S = (0, HOUR, -HOUR, 74 * YEAR, 0, -50 * YEAR, 0)  # of the machine's time of day, one after another
STAYS_S, NEAR_S = 6.0, 15.0
NOTICED = "the time of day was set by"

# ruff: noqa: TID251 - its tests are timed
pytestmark = [
    pytest.mark.timed,
    pytest.mark.skipif(LIBRARY is None, reason="the package libfaketime is not installed (apt install libfaketime)"),
]


class Demo:
    """A demo whose time of day is set by `set_ahead`."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.port, self.ahead_s = folder, free_port(), 0
        self._file = folder / "ahead"
        self.set_ahead(0)
        own = {k: v for k, v in os.environ.items() if not k.startswith(("FARHAND", "DATABASE", "REDIS", "SECRET"))}
        self.env = own | {
            "FARHAND_VAR": str(folder), "FARHAND_TURN_S": "3600",  # longer than a slow machine takes
            "LD_PRELOAD": str(LIBRARY), "FAKETIME_TIMESTAMP_FILE": str(self._file),
            "FAKETIME_NO_CACHE": "1",  # as on a machine, all processes are in the same time of day
            "FAKETIME_DONT_FAKE_MONOTONIC": "1", "NO_FAKE_STAT": "1",
            "PYTHONPATH": os.pathsep.join([str(HERE), str(ROOT)]),
        }  # fmt: skip
        with (folder / "log").open("wb") as out:
            self.process = subprocess.Popen(
                [sys.executable, "manage.py", "demo", "--port", str(self.port)],
                cwd=ROOT, env=self.env, stdout=out, stderr=out, start_new_session=True,
            )  # fmt: skip

    def set_ahead(self, seconds: int) -> None:
        new = self._file.with_suffix(".new")
        new.write_text(f"{seconds:+d}\n")
        new.replace(self._file)
        self.ahead_s = seconds

    def now(self) -> float:
        return time.time() + self.ahead_s

    def said(self) -> str:
        return (self.folder / "log").read_text()

    def rows(self, statement: str) -> list:
        with contextlib.closing(sqlite3.connect(self.folder / "farhand.sqlite3", timeout=20)) as store:
            return store.execute(statement).fetchall()

    def turn(self) -> tuple[str, int]:
        done = subprocess.run(
            [sys.executable, str(HERE / "turn.py")], cwd=ROOT, env=self.env, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        session, number = done.stdout.split()
        return session, int(number)

    def close(self) -> int:
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(CEILING_S)


@pytest.fixture
def demo(tmp_path):
    found = Demo(tmp_path)
    yield found
    sys.stdout.write(found.said()[-8000:])  # shown if the test fails
    if found.process.poll() is None:
        found.close()


def seconds_of(stamp: str) -> float:
    return datetime.fromisoformat(stamp).replace(tzinfo=UTC).timestamp()


def answered(line, number) -> tuple[float, int]:
    """Ping over a robot's socket; return the time that its answer told (s since 1970), and the packets before it."""
    line.send(json.dumps({"t": "ping", "n": number}))
    packets = 0
    while True:
        heard = line.recv(timeout=CEILING_S)
        if isinstance(heard, bytes):
            packets += 1
            continue
        told = json.loads(heard)
        if told["t"] == "pong" and told["n"] == number:
            return told["now_ms"] / 1000, packets


def test_nothing_ends_and_everything_goes_on_whenever_the_time_of_day_is_set(demo):
    for words in ("open http", "owner of mercury with", "owner of museum-arm with", "owner of irat with"):
        wait_for(lambda words=words: words in demo.said(), 120, words)
    wait_for(lambda: demo.rows("select cycle from robots_robot where slug='mercury'") == [("ready",)], 60, "the arm")
    session, turn = demo.turn()
    at = f"127.0.0.1:{demo.port}"
    cookie = {"Cookie": f"sessionid={session}"}
    with connect(
        f"ws://{at}/ws/robots/mercury/", origin=f"http://{at}", additional_headers=cookie, max_size=None
    ) as line:
        goes_on(demo, line, turn)
    for words in ("silent", "ended with status", "Traceback"):
        assert words not in demo.said(), demo.said()[-4000:]
    assert demo.close() == 0


def goes_on(demo, line, turn):
    """Set the time of day again and again, and look after each time at what ticks, lasts, and answers."""
    number, before = 0, None
    for steps, ahead_s in enumerate(AHEAD_S):
        demo.set_ahead(ahead_s)
        case, packets, begun = f"{ahead_s} s ahead", 0, time.monotonic()
        late = "not looked at"
        while time.monotonic() < begun + STAYS_S or (late and time.monotonic() < begun + CEILING_S):
            number += 1
            told, more = answered(line, number)
            packets += more
            late = behind(demo, turn, told, packets) or ("no tick" if demo.said().count(NOTICED) < steps else "")
            time.sleep(0.3)
        assert not late, f"{case}: {late}"
        ((ended, ends),) = demo.rows(f"select ended_at, until from queueing_turn where id={turn}")
        assert ended is None, f"{case}: the turn ended"
        left_s, was = seconds_of(ends) - demo.now(), before
        before = left_s, time.monotonic()
        if was is not None:
            assert abs(was[0] - left_s - (before[1] - was[1])) < 5, f"{case}: the turn lasts another time"


def behind(demo, turn, told, packets) -> str:
    """Return what has not gone on since the time of day was set; nothing if all has."""

    def near(at):
        return abs(at - demo.now()) < NEAR_S

    if not near(told):
        return "pages are told another time"
    if not packets:
        return "nothing comes from the robot"
    for slug, expires in demo.rows("select slug, expires_at from robots_lease join robots_robot r on r.id = robot_id"):
        if not near(seconds_of(expires)):
            return f"the lease of {slug} is not renewed"
    ((seen,),) = demo.rows(f"select last_seen from queueing_turn where id={turn}")
    return "" if near(seconds_of(seen)) else "the operator's page is not noted"
