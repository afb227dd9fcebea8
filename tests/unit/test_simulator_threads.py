"""A simulator whose thread has died ends with a word, and does not go on without it."""

import contextlib
import json
import os
import subprocess
import sys

import pytest

from simulators.so101.__main__ import MIDDLE
from simulators.so101.__main__ import Simulator as Servos
from tests.waiting import CEILING_S

DIES = """
import threading, sys
from pathlib import Path
from simulators.common.journal import Journal
from simulators.common.threads import end_with_any, record_deaths

end_with_any()
record_deaths(Journal(Path(sys.argv[1])))
threading.Thread(target=lambda: {}["gone"], name="watchdog", daemon=True).start()
threading.Event().wait()
"""


def test_a_thread_that_dies_ends_the_simulator_with_a_word(tmp_path):
    journal = tmp_path / "journal.jsonl"
    ended = subprocess.run(
        [sys.executable, "-c", DIES, str(journal)], capture_output=True, text=True, timeout=CEILING_S, check=False
    )
    assert ended.returncode == 1
    assert "the simulator ends, because its thread 'watchdog' died: KeyError('gone')" in ended.stderr
    assert "Traceback" in ended.stderr
    (told,) = map(json.loads, journal.read_text().splitlines())
    assert (told["event"], told["thread"], told["error"]) == ("thread_died", "watchdog", "KeyError('gone')")


REAL = """
import sys, threading
from simulators.common import process
from simulators.{robot} import __main__ as simulator

def stop_at_signals(_):
    threading.Thread(target=lambda: {{}}["gone"], name="watchdog", daemon=True).start()

process.stop_at_signals = stop_at_signals
sys.argv = ["simulator", "--dir", {folder!r}]
simulator.main()
"""


@pytest.mark.parametrize("robot", ["mercury", "pa10", "irat", "so101"])
def test_every_simulator_ends_so(robot, tmp_path):
    code = REAL.format(robot=robot, folder=str(tmp_path))
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=CEILING_S, check=False)
    assert (ended.returncode, "its thread 'watchdog' died" in ended.stderr) == (1, True), ended.stderr
    told = [json.loads(line) for line in (tmp_path / "journal.jsonl").read_text().splitlines()]
    assert [line["thread"] for line in told if line["event"] == "thread_died"] == ["watchdog"]


def full():
    """Return the ends of a pipe into which nothing fits any more."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(writing, bytes(1024))
    os.set_blocking(writing, True)
    return reading, writing


def test_a_simulator_whose_stderr_nobody_reads_ends_too(tmp_path):
    journal, (reading, writing) = tmp_path / "journal.jsonl", full()
    try:
        ended = subprocess.run(
            [sys.executable, "-c", DIES, str(journal)], stderr=writing, timeout=CEILING_S, check=False
        )
    finally:
        os.close(reading)
        os.close(writing)
    assert ended.returncode != 0
    (told,) = map(json.loads, journal.read_text().splitlines())
    assert told["event"] == "thread_died"


def test_a_simulator_whose_journal_cannot_be_written_ends_too(tmp_path):
    """A full disk, say."""
    code = DIES.replace("threading.Thread(", "Journal.note = lambda *_, **__: 1 / 0\nthreading.Thread(")
    ended = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "journal.jsonl")], capture_output=True, text=True,
        timeout=CEILING_S, check=False,
    )  # fmt: skip
    assert ended.returncode == 1
    assert "its thread 'watchdog' died: KeyError('gone')" in ended.stderr


def test_positions_that_cannot_be_read_are_the_middle(tmp_path):
    for kept in (
        "",
        "{}",
        "[1, 2]",
        "[NaN, 1, 1, 1, 1, 1]",
        "[1e308, 1, 1, 1, 1, 1]",
        "null",
        f"[{'9' * 400}]",
        "[[]]",
    ):
        (tmp_path / "places.json").write_text(kept)
        assert Servos(tmp_path).status()["ticks"] == [MIDDLE] * 6, kept
