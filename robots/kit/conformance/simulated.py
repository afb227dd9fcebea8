"""A robot's own simulator as a process, and its fault board."""

import json
import os
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robots.kit.clock import TIMER, poll
from robots.kit.installed import simulator_module

STARTS_S = 180.0  # real time; one may compile its loops first
ENDS_S = 20.0
ANSWER_S = 20.0


class NotStarted(Exception):
    """The simulator did not start; the text is its output."""


class Board:
    """The fault board of a simulator: a Unix socket that takes lines of JSON."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def _ask(self, **what: Any) -> dict[str, Any]:
        try:
            with socket.socket(socket.AF_UNIX) as line:
                line.settimeout(ANSWER_S)
                line.connect(str(self._path))
                line.sendall(json.dumps(what).encode() + b"\n")
                with line.makefile() as answers:
                    answer = json.loads(answers.readline())
        except (OSError, ValueError):
            return {}
        return answer if isinstance(answer, dict) else {}

    def set(self, verb: str, value: float = 1.0, count: int | None = None) -> bool:
        """Switch a fault on; tell whether the board took it."""
        more = {} if count is None else {"count": count}
        return self._ask(verb=verb, value=value, seed=1, **more).get("ok") is True

    def clear(self) -> None:
        """Switch all faults off."""
        self._ask(verb="clear")

    def motions(self) -> int | None:
        """Return how many motions the simulator has counted; None where it does not count them."""
        counts = self._ask(verb="status").get("counts")
        return int(counts.get("motion", 0)) if isinstance(counts, dict) else None

    def moving(self) -> bool | None:
        """Tell whether the simulated robot moves; None where the simulator does not tell it."""
        moving = self._ask(verb="status").get("moving")
        return moving if isinstance(moving, bool) else None

    def boots(self) -> int | None:
        """Return the number of the controller's present start; None where the simulator does not tell it."""
        boot = self._ask(verb="status").get("boot")
        return boot if isinstance(boot, int) else None


@dataclass(frozen=True)
class Simulated:
    """A simulator that runs, with the folder where it keeps its line, its cameras and its fault board."""

    folder: Path

    @property
    def address(self) -> str:
        """Return what the driver opens."""
        return str(self.folder / "tty")

    @property
    def board(self) -> Board | None:
        """Return its fault board, if it has one."""
        path = self.folder / "faults"
        return Board(path) if path.exists() else None

    def pictures(self, views: tuple[str, ...]) -> Mapping[str, str]:
        """Return the addresses of its cameras by view."""
        several, one = self.folder / "cameras.json", self.folder / "camera"
        if several.exists():
            return {str(view): str(address) for view, address in json.loads(several.read_text()).items()}
        return {views[0]: one.read_text().strip()} if views and one.exists() else {}


@contextmanager
def simulator(name: str, factor: float = 1.0) -> Iterator[Simulated]:
    """Run the simulator `name` in a folder of its own, `factor` times faster than real time. Raises NotStarted."""
    with tempfile.TemporaryDirectory(prefix="farhand-conform-", ignore_cleanup_errors=True) as kept:
        folder = Path(kept)
        argv = [sys.executable, "-m", simulator_module(name), "--dir", str(folder)]
        argv += ["--speed", str(factor)] if factor != 1.0 else []
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        with (folder / "said.log").open("wb") as out:
            process = subprocess.Popen(argv, env=env, stdout=out, stderr=subprocess.STDOUT)  # noqa: S603 - ours
        try:
            tty = folder / "tty"
            poll(lambda: tty.exists() or process.poll() is not None, TIMER, STARTS_S, 0.05)
            if not tty.exists():
                last = (folder / "said.log").read_text(errors="replace").strip().splitlines()[-1:]
                raise NotStarted(f"The simulator {name!r} did not start: {' '.join(last)[:300] or 'it says nothing'}")
            yield Simulated(folder)
        finally:
            _end(process)


def _end(process: "subprocess.Popen[bytes]") -> None:
    process.terminate()
    try:
        process.wait(ENDS_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
