"""A child is started again, whatever it prints, however it ends, and whoever reads the supervisor's output."""

import asyncio
import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from portal.live.previews import Previewer
from portal.logs.text import PRINTED
from portal.run.supervisor import ProcessSpec, Supervisor
from tests.conftest import wait_for
from tests.rig import ROOT
from tests.waiting import CEILING_S

PRINT = """
import os, pathlib, sys
starts = pathlib.Path(sys.argv[1])
with starts.open("a") as file:
    file.write("x")
data = {data}
while data:
    data = data[os.write(1, data):]
"""
OUTPUTS = {  # written as Python would
    "a line of 64 KiB": r'b"a" * 65_537 + b"\n"',
    "megabytes without an end": r'b"b" * 3_000_000',
    "bytes that are no text": r'b"\xff\xfe\x80" * 100_000 + b"\n\n\0\0\n"',
    "a forged line": r'b"one\r supervisor | two\x1b[2J\xc2\x9b\xe2\x80\xa8three\xe2\x80\xaefour\n" * 1000',
    "nothing": 'b""',
}


async def nobody():
    return []


def supervise(specs, tell, enough):
    """Supervise until `enough()`."""

    async def main():
        supervisor = Supervisor(specs, nobody, tell)
        supervisor.LOOK_S = 0.05
        task = asyncio.create_task(supervisor.run())
        async with asyncio.timeout(CEILING_S):
            while not enough():
                await asyncio.sleep(0.02)
        supervisor.ask_to_stop()
        await asyncio.wait_for(task, CEILING_S)
        return supervisor

    return asyncio.run(main())


def child(tmp_path, data, more=""):
    script = PRINT.format(data=data) + more
    return ProcessSpec("one", (sys.executable, "-c", script, str(tmp_path / "starts")))


def starts(tmp_path):
    with contextlib.suppress(FileNotFoundError):
        return (tmp_path / "starts").stat().st_size
    return 0


@pytest.mark.parametrize("what", OUTPUTS)
def test_a_child_is_started_again_whatever_it_printed(tmp_path, what):
    told = []
    data = OUTPUTS[what]
    supervise([child(tmp_path, data)], lambda name, text: told.append(text), lambda: starts(tmp_path) >= 3)
    assert all(text.isprintable() and len(text) < 2 * PRINTED for text in told)
    printed = [text for text in told if not text.startswith(("ended with", "stopping", "everything"))]
    assert bool(printed) == (what != "nothing")
    if what == "megabytes without an end":
        assert f"({3_000_000 - PRINTED} bytes left out)" in printed[0]


def test_a_child_whose_own_child_keeps_its_output_open_is_started_again(tmp_path):
    left = tmp_path / "left"
    more = f"""
import subprocess
held = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1000)"], start_new_session=True)
with open({str(left)!r}, "a") as file:
    file.write(f"{{held.pid}}\\n")
"""
    try:
        supervise([child(tmp_path, 'b""', more)], lambda *_: None, lambda: starts(tmp_path) >= 2)
    finally:
        for pid in left.read_text().split():
            os.kill(int(pid), signal.SIGKILL)


@pytest.mark.parametrize(
    "error", [OSError(12, "no memory"), ValueError("bad answer"), RuntimeError("no thread"), MemoryError()]
)
def test_a_child_that_cannot_be_started_is_tried_again(tmp_path, monkeypatch, error):
    failures = [error, error]
    told = []

    async def fork(*_):
        if failures:
            raise failures.pop()

    monkeypatch.setattr("portal.run.forks.fork", fork)
    supervise([child(tmp_path, 'b"up\\n"')], lambda name, text: told.append(text), lambda: "up" in told)
    assert sum(type(error).__name__ in text for text in told) == 2


def test_a_child_whose_start_cannot_be_watched_does_not_run_twice(tmp_path, monkeypatch):
    """The wait for the child fails: the child is ended before it is started again."""
    from asyncio.subprocess import Process

    waited = Process.wait
    pids = []

    async def wait(self):
        pids.append(self.pid)
        if len(pids) == 1:
            raise OSError(24, "Too many open files")
        return await waited(self)

    monkeypatch.setattr(Process, "wait", wait)
    told = []
    one = child(tmp_path, 'b""', "import time; print('up', flush=True); time.sleep(1000)")
    supervise([one], lambda name, text: told.append(text), lambda: len(pids) == 2 and "up" in told)
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)


def test_a_word_that_cannot_be_told_ends_nothing(tmp_path):
    def tell(name, text):
        raise UnicodeEncodeError("ascii", text, 0, 1, "a terminal of another kind")

    supervise([child(tmp_path, 'b"up\\n"')], tell, lambda: starts(tmp_path) >= 3)


ON_A_PIPE = """
import asyncio, sys
from portal.run.supervisor import ProcessSpec, Supervisor, flush

async def nobody():
    return []

spec = ProcessSpec("one", (sys.executable, "-c", sys.argv[1], sys.argv[2]))
asyncio.run(Supervisor([spec], nobody).run())
flush()
"""


@pytest.mark.parametrize("reads", ["nobody", "nobody any more"])
def test_a_supervisor_whose_output_nobody_reads_goes_on(tmp_path, reads):
    """A terminal that stands still, a pager, a service whose log is full: children print megabytes and are restarted."""
    ours, theirs = os.pipe()
    script = PRINT.format(data='(b"c" * 99 + b"\\n") * 20_000')
    supervisor = subprocess.Popen(
        [sys.executable, "-c", ON_A_PIPE, script, str(tmp_path / "starts")], cwd=ROOT, stdout=theirs,
        start_new_session=True,
    )  # fmt: skip
    os.close(theirs)
    try:
        if reads == "nobody any more":
            os.close(ours)
        wait_for(lambda: starts(tmp_path) >= 3, CEILING_S, "the third start")
        supervisor.send_signal(signal.SIGTERM)
        assert supervisor.wait(CEILING_S) == 0
        if reads == "nobody":
            assert os.read(ours, 100).startswith(b"             one | ccc")
    finally:
        supervisor.kill()
        if reads == "nobody":
            os.close(ours)


def test_a_previewer_whose_process_says_more_than_anybody_reads_ends_it():
    """Text that is left in the pipe of a killed process is no answer."""

    async def main():
        made = Previewer()
        flood = "import os\nwhile True: os.write(1, b'x' * 65536)"
        made._process = await asyncio.create_subprocess_exec(
            sys.executable, "-c", flood, stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE
        )
        async with asyncio.timeout(CEILING_S):
            while not made._process.stdout._paused:
                await asyncio.sleep(0.01)
            await made._end()
        assert made._process is None

    asyncio.run(main())
