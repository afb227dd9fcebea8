"""A simulator whose thread has died ends with a word, and does not go on without it."""

import inspect
import json
import subprocess
import sys
from importlib import import_module

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


@pytest.mark.parametrize("robot", ["mercury", "pa10", "irat", "so101"])
def test_every_simulator_ends_so(robot):
    """Its process says so first, before it makes a thread."""
    text = inspect.getsource(import_module(f"simulators.{robot}.__main__").main)
    assert '"""Run the simulator."""\n    end_with_any()\n' in text


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
