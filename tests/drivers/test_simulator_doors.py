"""The simulators' own interfaces, camera and fault board: no input there ends a thread or the process."""

import json
import socket
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from tests.conftest import wait_for
from tests.drivers.irat_wire import WireClient

pytestmark = pytest.mark.timed

UNREADABLE = (
    b"[]", b"{", b"7", b'{"verb": 3}', b'{"verb": "slow", "value": NaN}', b'{"verb": "slow", "value": 1e999}',
    b'{"verb": "drop", "count": "x"}', b'{"verb": "drop", "count": [1]}', b"\xff\xfe",
    b'{"verb": "slow", "value": ' + b"9" * 309 + b"}", b'{"verb": "slow", "value": ' + b"9" * 5000 + b"}",
    b'{"verb": "drop", "count": 1e999}', b"[" * 100_000,
)  # fmt: skip


def test_an_exposure_that_is_no_number_is_refused(sim):
    camera = (sim.folder / "camera").read_text().strip()
    for asked in ("nan", "inf", "-inf", "1e400", "x", "9" * 5000, "%00"):
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(f"{camera}/snapshot.jpg?exposure={asked}", timeout=5)
        assert refused.value.code == 400
        refused.value.close()
    with urllib.request.urlopen(f"{camera}/snapshot.jpg?exposure=0.01", timeout=10) as answer:
        assert answer.status == 200
    assert sim.count("thread_died") == 0


def test_what_the_fault_board_cannot_read_changes_nothing(sim):
    for line in UNREADABLE:
        with socket.socket(socket.AF_UNIX) as s:
            s.settimeout(5)
            s.connect(str(sim.folder / "faults"))
            s.sendall(line + b"\n")
            assert json.loads(s.makefile().readline())["ok"] is False
    assert sim.ask(verb="status")["faults"] == {}
    assert sim.process.poll() is None


BURST = 1500


def descriptors(sim):
    return len(list(Path(f"/proc/{sim.process.pid}/fd").iterdir()))


@pytest.fixture
def lines():
    """Connections, closed at the end."""
    opened = []
    yield opened
    for line in opened:
        line.close()


def test_a_burst_of_connections_takes_few_descriptors(irat, lines):
    before, most = descriptors(irat), 0
    for number in range(BURST):
        line = socket.socket()
        lines.append(line)
        line.setblocking(False)
        line.connect_ex(("127.0.0.1", int(irat.address.rsplit(":", 1)[1])))
        if number % 50 == 0:
            most = max(most, descriptors(irat))
    assert most - before <= 64 + 6 * 16, "the limit, and those that were accepted and not closed yet"
    wait_for(lambda: descriptors(irat) - before <= 64 + 8, 20, "the others' end")
    assert WireClient(irat).status()["moving"] is False
    assert irat.count("thread_died") == irat.count("crash") == 0


def test_silent_connections_use_up_no_camera(irat, lines):
    at, before = (irat.folder / "overhead").read_text().strip(), descriptors(irat)
    for _ in range(200):
        lines.append(socket.create_connection(("127.0.0.1", int(at.rsplit(":", 1)[1])), timeout=5))
    wait_for(lambda: descriptors(irat) - before <= 64, 20, "those that are too many are closed")
    assert len(irat.status()["threads"]) <= 64 + 20

    def served():
        try:
            with urllib.request.urlopen(f"{at}/snapshot.jpg", timeout=5) as answer:
                return answer.status == 200
        except OSError:
            return False

    wait_for(served, 30, "a picture, once those who said nothing are gone")
    assert irat.count("thread_died") == 0


def test_a_strangers_flood_writes_few_lines_into_the_journal(irat):
    stranger = WireClient(irat)
    for _ in range(600):
        stranger.drive(linear=0.1)
        assert "claim the robot first" in stranger.complaint()
    assert irat.count("refused") == 600
    assert len([record for record in irat.journal() if record["event"] == "refused"]) < 300
