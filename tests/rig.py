"""The rig: real simulator, real worker, real web process, on the tests' own stores and ports."""

import contextlib
import json
import os
import random
import signal
import socket
import subprocess
import sys
import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

from django.conf import settings
from django.db import connection

from robots.kit.clock import FasterTimer
from tests.waiting import CEILING_S, wait_for

ROOT = Path(__file__).resolve().parent.parent
PYTHON = sys.executable
PORTS = range(10240, 32768)  # below those that Linux gives to connections


def started(argv: list[str], env: Mapping[str, str], out: BinaryIO) -> subprocess.Popen:
    """Start a process in a session of its own that writes to `out`."""
    return subprocess.Popen(argv, cwd=ROOT, env=env, stdout=out, stderr=subprocess.STDOUT, start_new_session=True)


class Simulator:
    """The Mercury arm's simulator as a process; `status` and `fault` reach it while it runs.

    `before`: the command that starts it, if any; `speed`: how many times faster than real time it runs.
    """

    def __init__(
        self,
        folder: Path,
        seed: int = 1,
        tcp: int | None = None,
        baud: int = 4800,
        before: tuple[str, ...] = (),
        speed: float = 1.0,
    ) -> None:
        self.folder, self.seed, self.tcp, self.baud, self.speed = folder, seed, tcp, baud, speed
        self._before = before
        self.process: subprocess.Popen | None = None
        self._counted: dict[str, int] = {}
        self._read = 0  # bytes of the journal
        self.start()

    def start(self) -> None:
        self._counted = {}
        (self.folder / "camera").unlink(missing_ok=True)
        self._run("mercury", "--seed", self.seed, "--baud", self.baud, *(["--tcp", self.tcp] if self.tcp else []))
        wait_for((self.folder / "camera").exists, 60, "the simulator")

    def _run(self, name: str, *options: object) -> None:
        argv = [*self._before, PYTHON, "-m", f"simulators.{name}", "--dir", str(self.folder)]
        argv += ["--speed", str(self.speed), *map(str, options)]
        self.folder.mkdir(parents=True, exist_ok=True)
        with (self.folder / "said.log").open("ab") as out:
            self.process = started(argv, os.environ, out)

    def stop(self) -> None:
        if self.process is not None:
            self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
            self.process.wait(CEILING_S)

    def ask(self, board: str = "faults", **message) -> dict:
        with socket.socket(socket.AF_UNIX) as s:
            s.settimeout(CEILING_S)
            s.connect(str(self.folder / board))
            s.sendall(json.dumps(message).encode() + b"\n")
            return json.loads(s.makefile().readline())

    def fault(self, verb: str, value: float = 1.0, **more) -> None:
        answer = self.ask(verb=verb, value=value, **more)
        assert answer["ok"], answer

    def clear(self) -> None:
        self.ask(verb="clear")

    def power_cycle(self) -> None:
        """Switch it off and on again; return when it has begun anew."""
        boot = self.status()["boot"]
        self.fault("power_cycle", count=1)
        wait_for(lambda: self.status()["boot"] != boot, 5, "the power")

    def forget(self) -> None:
        """Count anew, and read the journal from here on."""
        self._counted = self.ask(verb="status")["counts"]
        self._read = (self.folder / "journal.jsonl").stat().st_size

    def status(self) -> dict:
        status = self.ask(verb="status")
        return status | {"counts": {name: n - self._counted.get(name, 0) for name, n in status["counts"].items()}}

    def count(self, event: str) -> int:
        return self.status()["counts"].get(event, 0)

    def journal(self) -> list[dict]:
        with (self.folder / "journal.jsonl").open() as lines:
            lines.seek(self._read)
            return [json.loads(line) for line in lines]


class ArmSimulator(Simulator):
    """The museum arm's simulator as a process; `options` are those of its command, `clock` is the time it lives in."""

    module = "pa10"

    def __init__(self, folder: Path, before: tuple[str, ...] = (), **options: float) -> None:
        self._options = [part for name, value in options.items() for part in (f"--{name}", str(value))]
        self.clock = FasterTimer(options.get("speed", 1))
        super().__init__(folder, before=before)

    def start(self) -> None:
        self._counted = {}
        for name in ("tty", "cameras.json"):
            (self.folder / name).unlink(missing_ok=True)
        self._run(self.module, *self._options)
        wait_for((self.folder / "tty").exists, 60, "the arm's simulator")
        wait_for((self.folder / "cameras.json").exists, 60, "its cameras")

    def fault(self, verb: str, value: float = 1.0, **more) -> None:
        board = "camera_faults" if verb.startswith("cam_") else "faults"
        answer = self.ask(board, verb=verb, value=value, **more)
        assert answer["ok"], answer

    def clear(self) -> None:
        for board in ("faults", "camera_faults"):
            self.ask(board, verb="clear")

    def status(self) -> dict:
        status = super().status()
        return status | {"pose": status["objects"]["tip"]}


class PumaSimulator(ArmSimulator):
    """The PUMA 560's simulator as a process."""

    module = "puma"


class IratSimulator(Simulator):
    """The iRat's simulator as a process; `options` and `clock` as above."""

    module = "irat"

    def __init__(self, folder: Path, seed: int = 1, **options: float) -> None:
        self._options = [part for name, value in options.items() for part in (f"--{name}", str(value))]
        self.clock = FasterTimer(options.get("speed", 1))
        super().__init__(folder, seed)

    def start(self) -> None:
        self._counted = {}
        (self.folder / "tty").unlink(missing_ok=True)
        self._run(self.module, "--seed", self.seed, *self._options)
        wait_for((self.folder / "tty").exists, 120, "the simulator, which compiles at its first start")

    @property
    def address(self) -> str:
        return (self.folder / "tty").read_text().strip()


class RoverSimulator(IratSimulator):
    """The hall rover's simulator as a process."""

    module = "srv1"


class Board(IratSimulator):
    """The faults of an iRat's simulator that the supervisor's command has started."""

    def start(self) -> None:
        self._counted = {}


def child_env(**more: str) -> dict[str, str]:
    """Return the environment in which a child finds the tests' own stores."""
    db = connection.settings_dict
    if connection.vendor == "sqlite":
        url = f"sqlite:///{db['NAME']}"
    else:
        url = f"postgres://{db['USER']}:@{db['HOST'].replace('/', '%2F')}/{db['NAME']}"
    return {
        **os.environ,
        "DATABASE_URL": url,
        "FARHAND_VAR": str(settings.VAR),
        "REDIS_URL": settings.REDIS_URL,
        **more,
    }


class Child:
    """One process of ours; its output is kept for the moment a test fails."""

    def __init__(self, name: str, argv: list[str], **env: str) -> None:
        self.log = Path(settings.VAR) / f"{name}-{uuid.uuid4().hex[:8]}.log"
        with self.log.open("wb") as out:
            self.process = started(argv, child_env(**env), out)

    @property
    def pid(self) -> int:
        return self.process.pid

    def alive(self) -> bool:
        return self.process.poll() is None

    def frozen(self) -> bool:
        """Tell whether it has been stopped by SIGSTOP."""
        return Path(f"/proc/{self.pid}/stat").read_text().rpartition(") ")[2][0] == "T"

    def signal(self, number: int) -> None:
        if self.alive():
            with contextlib.suppress(ProcessLookupError):  # it has ended by now
                os.killpg(self.pid, number)

    def stop(self, seconds: float = CEILING_S) -> int:
        self.signal(signal.SIGCONT)
        self.signal(signal.SIGTERM)
        try:
            return self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.kill()
            raise

    def kill(self) -> None:
        self.signal(signal.SIGKILL)
        self.process.wait()

    def said(self) -> str:
        return self.log.read_text(errors="replace")


def worker(slug: str = "mercury", doom: str = "", before: tuple[str, ...] = (), **env: str) -> Child:
    """Start a robot's worker exactly as the supervisor does; `before`: the command that starts it, if any.

    `doom`: the signal that it sends itself before a motion is sent.
    """
    from portal.run.processes import robot_processes
    from robots.models import Robot

    spec = next(p for p in robot_processes(Robot.objects.get(slug=slug)) if p.name.endswith("worker"))
    argv = list(spec.argv)
    if doom:
        argv = [PYTHON, "-m", "tests.faults.doomed", doom, "--", *argv[3:]]
    return Child("worker", [*before, *argv], **{**spec.env, **env})


def housekeeping() -> Child:
    """Start the housekeeping worker with its scheduler."""
    from portal.run.processes import housekeeping_process

    spec = housekeeping_process()
    return Child("housekeeping", list(spec.argv), **spec.env)


def free_port() -> int:
    """Return a port that nobody listens on, and that no connection is given before it is used."""
    for port in random.SystemRandom().sample(PORTS, 100):
        with contextlib.suppress(OSError), socket.socket() as s:
            s.bind(("127.0.0.1", port))
            return port
    raise OSError("none of 100 ports is free")


class Web(Child):
    """The web process."""

    def __init__(self, port: int | None = None, **env: str) -> None:
        from portal.run.processes import web_process

        self.port = port or free_port()
        spec = web_process("127.0.0.1", self.port)
        self.url = f"http://localhost:{self.port}"
        super().__init__("web", list(spec.argv), **{**spec.env, "FARHAND_URL": self.url, **env})
        wait_for(self._answers, 60, "the web process")

    def _answers(self) -> bool:
        import urllib.request

        assert self.alive(), self.said()
        try:
            with urllib.request.urlopen(f"{self.url}/livez", timeout=10) as answer:
                return answer.status == 200
        except OSError:
            return False
