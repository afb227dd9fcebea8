"""The supervisor restarts processes that end, kills silent ones, and leaves no orphan."""

import asyncio
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from portal.run.supervisor import ProcessSpec, Supervisor
from tests.conftest import at_length, wait_for
from tests.rig import ROOT, free_port
from tests.waiting import CEILING_S

SLEEPER = (sys.executable, "-c", "import time; print('up', flush=True); time.sleep(1000)")


def run(supervisor, story):
    async def main():
        task = asyncio.create_task(supervisor.run())
        try:
            await story()
        finally:
            supervisor.ask_to_stop()
            await asyncio.wait_for(task, 30)

    asyncio.run(main())


async def until(condition, seconds=10):
    async with asyncio.timeout(seconds):
        while not condition():
            await asyncio.sleep(0.02)


async def nothing():
    return []


@pytest.mark.timed
def test_what_dies_is_started_again_and_one_line_a_process_is_shown():
    lines = []
    supervisor = Supervisor([ProcessSpec("one", SLEEPER)], nothing, lambda name, text: lines.append((name, text)))

    async def story():
        await until(lambda: ("one", "up") in lines)
        os.kill(supervisor.children["one"]._process.pid, signal.SIGKILL)
        await until(lambda: lines.count(("one", "up")) == 2)

    run(supervisor, story)
    assert any("starting it again" in text for _, text in lines)


@pytest.mark.timed
def test_a_silent_control_loop_is_killed(tmp_path, monkeypatch):
    monkeypatch.setattr("portal.run.supervisor.HEARTBEAT_S", 1.0)
    beat = tmp_path / "beat"
    lines = []
    script = (
        f"import pathlib, time; p = pathlib.Path({str(beat)!r}); p.touch(); print('up', flush=True); time.sleep(1000)"
    )
    spec = ProcessSpec("robot", (sys.executable, "-c", script), heartbeat=beat)
    supervisor = Supervisor([spec], nothing, lambda name, text: lines.append(text))

    async def story():
        await until(lambda: lines.count("up") == 2, 15)

    run(supervisor, story)
    assert any("control loop is silent" in text for text in lines)


@pytest.mark.parametrize("ahead_s", [-3600, 3600, 2e9, -1.7e9])
def test_a_control_loop_that_goes_round_lives_whatever_the_time_of_day_is(tmp_path, ahead_s):
    """Its file has the stamps of another time of day than the supervisor's, and then again of this one."""
    beat, lines = tmp_path / "beat", []
    script = (
        "import os, pathlib, sys, time\n"
        f"path, n = pathlib.Path({str(beat)!r}), 0\n"
        "while True:\n"
        "    path.touch()\n"
        f"    at = time.time() + (n < 50) * {ahead_s} + n / 1000\n"
        "    os.utime(path, (at, at))\n"
        "    n += 1\n"
        "    print('up' if n == 1 else 'round', flush=True)\n"
        "    time.sleep(0.02)\n"
    )
    spec = ProcessSpec("robot", (sys.executable, "-c", script), heartbeat=beat)
    supervisor = Supervisor([spec], nothing, lambda name, text: lines.append(text))
    supervisor.LOOK_S = 0.05

    async def story():
        await until(lambda: lines.count("round") >= 100, CEILING_S)

    run(supervisor, story)
    assert lines.count("up") == 1
    assert not any("silent" in text for text in lines)


@pytest.mark.timed
def test_it_follows_what_the_database_wants():
    wanted = [ProcessSpec("a", SLEEPER)]

    async def now():
        return list(wanted)

    lines = []
    supervisor = Supervisor([], now, lambda name, text: lines.append((name, text)))

    async def story():
        await until(lambda: ("a", "up") in lines)
        pid = supervisor.children["a"]._process.pid
        wanted.clear()
        await until(lambda: "a" not in supervisor.children)
        await until(lambda: not Path(f"/proc/{pid}").exists())

    run(supervisor, story)


CAREFUL = (sys.executable, "-c", """
import signal, sys, time
signal.signal(signal.SIGTERM, lambda *_: (print("held", flush=True), sys.exit()))
print("up", flush=True)
time.sleep(1000)
""")  # fmt: skip
DEAF = (sys.executable, "-c", """
import signal, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
print("up", flush=True)
time.sleep(1000)
""")  # fmt: skip


@pytest.mark.timed
@pytest.mark.parametrize("what", ["the database", "another process"])
def test_a_stop_of_everything_waits_for_nothing_that_is_looked_after(monkeypatch, what):
    """The supervisor was asking the database for the robots, or ending one that nobody wants: others are held at once."""
    monkeypatch.setattr("portal.run.supervisor.STOP_S", 4.0)
    wanted, lines, looked = [ProcessSpec("deaf", DEAF)], [], asyncio.Event()

    async def robots():
        if ("robot", "up") not in lines or ("deaf", "up") not in lines:
            return wanted
        looked.set()
        if what == "the database":
            await asyncio.sleep(1000)
        return []

    supervisor = Supervisor([ProcessSpec("robot", CAREFUL)], robots, lambda *line: lines.append(line))
    supervisor.LOOK_S = 0.1

    async def main():
        task = asyncio.create_task(supervisor.run())
        await asyncio.wait_for(looked.wait(), 20)
        pids = [child.pid for child in supervisor.children.values()]
        await asyncio.sleep(0.2)
        supervisor.ask_to_stop()
        await asyncio.wait_for(task, 30)
        return pids

    pids = asyncio.run(main())
    assert len(pids) == 2
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)
    assert lines.index(("robot", "held")) < lines.index(("deaf", "did not stop in time; killing it"))


@pytest.mark.timed
def test_the_owner_of_a_robot_that_is_switched_off_ends_before_its_simulator():
    """It could not hold the robot otherwise."""
    holding = (sys.executable, "-c", CAREFUL[2].replace('(print("held"', '(time.sleep(1), print("held"'))
    wanted = [ProcessSpec("simulator", CAREFUL, rank=1), ProcessSpec("owner", holding, rank=0)]
    lines = []

    async def now():
        return list(wanted)

    supervisor = Supervisor([], now, lambda *line: lines.append(line))
    supervisor.LOOK_S = 0.1

    async def story():
        await until(lambda: lines.count(("owner", "up")) == lines.count(("simulator", "up")) == 1)
        wanted[:] = [ProcessSpec("simulator", CAREFUL, {"ANOTHER": "1"}, rank=1)]  # its owner must go first there, too
        await until(lambda: lines.count(("simulator", "up")) == 2)
        wanted.clear()
        await until(lambda: not supervisor.children)

    run(supervisor, story)
    assert [name for name, text in lines if text == "held"] == ["owner", "simulator", "simulator"]


@pytest.mark.timed
def test_a_process_that_is_just_being_started_is_asked_to_stop_before_it_is_killed(monkeypatch):
    monkeypatch.setattr("portal.run.supervisor.STOP_S", 6.0)
    begun, lines = asyncio.Event(), []

    async def late(*_):
        begun.set()
        await asyncio.sleep(0.5)

    monkeypatch.setattr("portal.run.forks.fork", late)
    supervisor = Supervisor([ProcessSpec("robot", CAREFUL)], nothing, lambda *line: lines.append(line))
    run(supervisor, begun.wait)
    assert ("robot", "did not stop in time; killing it") not in lines


def demo_in(folder, port):
    """Return a demo with its log in the folder."""
    env = {k: v for k, v in os.environ.items() if not k.startswith(("FARHAND", "DATABASE", "REDIS", "SECRET"))}
    with (folder / "log").open("wb") as out:
        return subprocess.Popen(
            [sys.executable, "manage.py", "demo", "--port", str(port)], cwd=ROOT, env=env | {"FARHAND_VAR": str(folder)},
            stdout=out, stderr=out, start_new_session=True,
        )  # fmt: skip


@pytest.mark.timed
@pytest.mark.length
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_a_demo_that_is_ended_before_it_serves_tells_the_first_password(tmp_path, how):
    port, log = free_port(), tmp_path / "log"
    demo = demo_in(tmp_path, port)
    with socket.socket() as taken:
        wait_for((tmp_path / "farhand.sqlite3").exists, 60, "the database")
        taken.bind(("127.0.0.1", port))  # after the demo has looked whether it is free
        taken.listen()
        wait_for(lambda: "| " in log.read_text(), 60, "its first process")
        demo.send_signal(how)
        assert demo.wait(40) == 0
    assert "open http" not in log.read_text()
    assert log.read_text().count("one-time password:") == 1


@pytest.mark.parametrize("how", [signal.SIGINT, at_length(signal.SIGTERM)])
def test_the_demo_starts_serves_and_leaves_no_orphan(tmp_path, how):
    port = free_port()
    demo = demo_in(tmp_path, port)
    log = tmp_path / "log"
    try:
        wait_for(lambda: "open http://localhost" in log.read_text(), 60, "the address")
        text = log.read_text()
        assert f"open http://localhost:{port}" in text
        assert "one-time password:" in text
        for robot in ("mercury", "museum-arm", "irat"):
            wait_for(lambda robot=robot: f"owner of {robot} with" in log.read_text(), 60, f"the owner of {robot}")
            assert f"{robot} worker" in log.read_text()
    finally:
        demo.send_signal(how)
        code = demo.wait(CEILING_S)
    assert code == 0
    assert "everything has stopped" in log.read_text()
    of_it = f"FARHAND_VAR={tmp_path}".encode()

    def left():
        return [path for path in Path("/proc").glob("[0-9]*/environ") if _holds(path, of_it)]

    wait_for(lambda: not left(), 10, "the end of what it had forked, which hears of its own")


def _holds(path, text):
    try:
        return text in path.read_bytes()
    except OSError:
        return False
