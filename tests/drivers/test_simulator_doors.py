"""The simulators' own interfaces, camera and fault board: no input there ends a thread or the process."""

import json
import socket
import urllib.error
import urllib.request

import pytest

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
