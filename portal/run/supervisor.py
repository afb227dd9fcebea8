"""The supervisor of all processes of one machine: starts, watches, restarts and stops them.

It judges a robot's worker by a local heartbeat file, which the worker touches while its watch goes round, not by Redis
or the database. It starts workers and simulators of the robots that are enabled in the database.
"""

import asyncio
import contextlib
import ctypes
import os
import signal
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from portal.folders import ROOT
from portal.logs.outlet import Outlet
from portal.logs.text import PRINTED, tidy
from portal.run import forks
from robots.kit.clock import SYSTEM

HEARTBEAT_S = 10.0
GRACE_S = 25.0
STOP_S = 15.0
BACKOFF_S = (0.3, 1.0, 2.0, 5.0)
REST_S = 1.0  # after a child's end, for the rest of its output; a process that it left behind may hold the pipe open
CHUNK = 65_536  # bytes that are read at once
PR_SET_PDEATHSIG = 1
Print = Callable[[str, str], None]


@dataclass(frozen=True)
class ProcessSpec:
    """A process to run: name, command, environment, and place in the order of stopping."""

    name: str
    argv: tuple[str, ...]
    env: dict[str, str] = field(default_factory=dict)
    rank: int = 0  # smaller ranks stop first
    heartbeat: Path | None = None


def _die_with_parent() -> None:
    """Ask the kernel to end this child when the supervisor ends, for whatever reason."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


class Child:
    """One process, started again whenever it ends."""

    def __init__(self, spec: ProcessSpec, tell: Print) -> None:
        self.spec = spec
        self._tell = unfailing(tell)
        self._process: asyncio.subprocess.Process | forks.Forked | None = None
        self._stopping: asyncio.Task[None] | None = None
        self._started = 0.0
        self._touched, self._heard_at = 0, 0.0  # the heartbeat file's stamp (ns), and when it was another (s)
        self.restarts = 0
        self._task = asyncio.create_task(self._keep())

    async def _keep(self) -> None:
        while not self.stopping:
            try:
                await self._once()
            except Exception as error:  # noqa: BLE001 - whatever it was, the process is needed
                self._tell(self.spec.name, f"could not be started or watched: {type(error).__name__}: {error}")
            if self.stopping:
                return
            ran = SYSTEM.awake() - self._started
            pause = BACKOFF_S[min(self.restarts, len(BACKOFF_S) - 1)] if ran < 30 else BACKOFF_S[0]
            self.restarts = self.restarts + 1 if ran < 30 else 0
            code = self._process.returncode if self._process else None
            self._tell(self.spec.name, f"ended with status {code}; starting it again in {pause:g} s")
            await asyncio.sleep(pause)

    async def _once(self) -> None:
        self._started = SYSTEM.awake()
        if self.spec.heartbeat is not None:
            self.spec.heartbeat.unlink(missing_ok=True)
        self._process = None
        ours, theirs = os.pipe()
        try:
            self._process = await self._begin({**os.environ, **self.spec.env}, theirs)
        except BaseException:
            os.close(ours)
            raise
        finally:
            os.close(theirs)
        reading = asyncio.create_task(self._read(ours))
        try:
            if self.stopping:  # it was being started when everything was asked to stop
                self._signal(signal.SIGTERM)
            await self._process.wait()
            await asyncio.wait({reading}, timeout=REST_S)
        finally:
            self._signal(signal.SIGKILL)  # if it was not waited for: two must never run
            reading.cancel()

    async def _begin(self, env: dict[str, str], out: int) -> "asyncio.subprocess.Process | forks.Forked":
        return await forks.fork(self.spec.name, self.spec.argv, env, ROOT, out) or await asyncio.create_subprocess_exec(
            *self.spec.argv, env=env, cwd=ROOT, stdin=asyncio.subprocess.DEVNULL, stdout=out,
            stderr=asyncio.subprocess.STDOUT, start_new_session=True, preexec_fn=_die_with_parent,
        )  # fmt: skip

    async def _read(self, pipe: int) -> None:
        """Tell each line of its output, of a long one the beginning; the pipe is emptied whatever is in it."""
        lines = Lines()
        async for data in chunks(pipe):
            for text in lines.take(data):
                self._tell(self.spec.name, text)
        for text in lines.take(b"\n"):
            self._tell(self.spec.name, text)

    @property
    def pid(self) -> int:
        """Return the id of the present process; 0 while it starts."""
        return self._process.pid if self._process else 0

    @property
    def stopping(self) -> bool:
        """Return whether it was asked to stop."""
        return self._stopping is not None

    def check_heartbeat(self) -> None:
        """Kill a child whose heartbeat file has not changed for too long by a clock that is never set."""
        path = self.spec.heartbeat
        if path is None or self._process is None or self._process.returncode is not None:
            return
        try:
            touched = path.stat().st_mtime_ns
        except FileNotFoundError:
            silent = SYSTEM.awake() - self._started - GRACE_S if self._waits_for_lease() is False else 0.0
        else:
            if touched != self._touched:
                self._touched, self._heard_at = touched, SYSTEM.awake()
            silent = SYSTEM.awake() - self._heard_at
        if silent > HEARTBEAT_S:
            self._tell(self.spec.name, f"its control loop is silent for {silent:.0f} s; killing it")
            self._signal(signal.SIGKILL)

    def _waits_for_lease(self) -> bool:
        return SYSTEM.awake() - self._started < GRACE_S

    def _signal(self, number: int) -> None:
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, number)

    def stop(self) -> asyncio.Task[None]:
        """Stop the child: SIGTERM, and SIGKILL after `STOP_S`. Return the task that does it, the same at each call."""
        if self._stopping is None:
            self._stopping = asyncio.create_task(self._stop())
        return self._stopping

    async def _stop(self) -> None:
        self._signal(signal.SIGTERM)
        done, _ = await asyncio.wait({self._task}, timeout=STOP_S)
        if not done:
            self._tell(self.spec.name, "did not stop in time; killing it")
            self._signal(signal.SIGKILL)
            await asyncio.wait({self._task}, timeout=3)
        self._task.cancel()


class Supervisor:
    """Runs fixed processes, and those that `wanted` returns at each look."""

    LOOK_S = 1.0

    def __init__(
        self, fixed: list[ProcessSpec], wanted: Callable[[], Awaitable[list[ProcessSpec]]], tell: Print | None = None
    ) -> None:
        self._fixed, self._wanted = fixed, wanted
        self._tell = unfailing(tell or tidy_line)
        self.children: dict[str, Child] = {}
        self._end = asyncio.Event()
        self._reading: asyncio.Future[list[ProcessSpec]] | None = None

    def ask_to_stop(self) -> None:
        """Start to stop."""
        self._end.set()

    async def run(self, ready: Callable[[], Coroutine[Any, Any, None]] | None = None) -> None:
        """Start everything, watch it, stop everything in order."""
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            loop.add_signal_handler(number, self.ask_to_stop)
        for spec in self._fixed:
            self.children[spec.name] = Child(spec, self._tell)
        announce = asyncio.create_task(ready()) if ready else None
        end = asyncio.create_task(self._end.wait())
        try:
            while not end.done():
                self._check()
                await self._follow(end)
                await asyncio.wait({end}, timeout=self.LOOK_S)
        finally:
            for task in (announce, end, self._reading):
                if task is not None:
                    task.cancel()
            await self._stop_all()

    def _check(self) -> None:
        for child in self.children.values():
            child.check_heartbeat()
        forks.reap({child.pid for child in self.children.values()})

    async def _follow(self, end: asyncio.Future[Any]) -> None:
        """Start and stop processes as the database says. If it does not answer, no check and no stop is delayed."""
        if self._reading is None:
            self._reading = asyncio.ensure_future(self._wanted())
        await asyncio.wait({self._reading, end}, timeout=self.LOOK_S, return_when=asyncio.FIRST_COMPLETED)
        if end.done() or not self._reading.done():
            return
        reading, self._reading = self._reading, None
        try:
            wanted = {p.name: p for p in reading.result()}
        except Exception as error:  # noqa: BLE001 - a database that is down stops nothing that runs
            self._tell("supervisor", f"cannot read the robots now: {error}")
            return
        fixed = {p.name for p in self._fixed}
        leaving = {
            name: child
            for name, child in self.children.items()
            if name not in fixed and (child.stopping or child.spec != wanted.get(name))
        }
        first = min((child.spec.rank for child in leaving.values()), default=0)
        for name, child in leaving.items():
            if child.spec.rank > first:
                continue  # a simulator while an owner still holds its robot
            if name not in wanted and not child.stopping:
                self._tell("supervisor", f"stopping {name}")
            if child.stop().done():
                del self.children[name]
        for name, spec in wanted.items():
            if name not in self.children:
                self.children[name] = Child(spec, self._tell)

    async def _stop_all(self) -> None:
        self._tell("supervisor", "stopping; robots are held first")
        for rank in sorted({c.spec.rank for c in self.children.values()}):
            await asyncio.gather(*(c.stop() for c in self.children.values() if c.spec.rank == rank))
        self._tell("supervisor", "everything has stopped")


def unfailing(tell: Print) -> Print:
    """Return a `tell` that loses a line rather than raise: no process may depend on it."""

    def told(name: str, text: str) -> None:
        with contextlib.suppress(Exception):
            tell(name, text)

    return told


class Lines:
    """Divides bytes into lines without control characters; keeps `PRINTED` bytes of a line at most."""

    def __init__(self) -> None:
        self._begun, self._more = b"", 0

    def take(self, data: bytes) -> list[str]:
        """Return the lines that end in `data`, without empty ones."""
        *ended, rest = data.split(b"\n")
        made = []
        for part in ended:
            self._add(part)
            text = tidy(self._begun.decode(errors="replace").rstrip(), PRINTED)
            if text:
                made.append(f"{text} ... ({self._more} bytes left out)" if self._more else text)
            self._begun, self._more = b"", 0
        self._add(rest)
        return made

    def _add(self, part: bytes) -> None:
        kept = part[: PRINTED - len(self._begun)]
        self._begun += kept
        self._more += len(part) - len(kept)


async def chunks(pipe: int) -> AsyncIterator[bytes]:
    """Yield what comes out of a pipe, until it ends; then close it."""
    loop, reader = asyncio.get_running_loop(), asyncio.StreamReader()
    line, _ = await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(pipe, "rb"))
    try:
        while data := await reader.read(CHUNK):
            yield data
    finally:
        line.close()


_shown = Outlet(1)  # a terminal that is stopped, or a pipe that nobody reads, does not block the supervisor


def tidy_line(name: str, text: str) -> None:
    """Print one line of one process."""
    _shown.write(f"{name:>16} | {tidy(text, PRINTED + 100)}")


def flush() -> bool:
    """Wait a moment until all lines are printed. Return whether they are."""
    return _shown.flush()
