"""The tests' processes as forks of one that has loaded their libraries, in the way in which `make run` starts them.

A process of ours spends two seconds of the processor on its imports, and a test run starts hundreds. The process that
forks is started by the first test that needs it and ends with the test process. What the supervisor starts, with the
tests' ordinary environment, is forked of a second one, which has read the settings and loaded our modules, too. Where a
process needs another interpreter, a command before it or other libraries, or on a system other than Linux, it is
started in the ordinary way.
"""

import contextlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NoReturn

from portal import forks

ROOT = Path(__file__).resolve().parent.parent
OF_SIMULATORS = ("numba.core.registry", "mujoco", "scipy.ndimage", "PIL.Image")
LIBRARIES = (*forks.LIBRARIES, *OF_SIMULATORS)  # those of `make run`, too
LOADED = {name.partition(".")[0] for name in LIBRARIES}
SAME = ("PYTHONPYCACHEPREFIX", "PYTHONDONTWRITEBYTECODE", "LD_LIBRARY_PATH", "LD_PRELOAD")  # read at start
ENDED = b"ended "
LOAD = b"load "
LOADED_FOR = ("celery", "portal.serve")  # what is not run in variants of the tests


class Forked:
    """A fork with the interface of `subprocess.Popen` that tests use."""

    def __init__(self, pid: int, server: "Server") -> None:
        self.pid, self._server = pid, server
        self.returncode: int | None = None
        try:
            self._descriptor = os.pidfd_open(pid)
        except ProcessLookupError:  # it has ended already
            self._descriptor = -1

    def poll(self) -> int | None:
        """Return the exit status, or None while it runs."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.wait(0)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Return the exit status after it has ended; raise `TimeoutExpired`."""
        if self.returncode is None:
            if self._descriptor >= 0:
                waiting = select.poll()
                waiting.register(self._descriptor, select.POLLIN)
                if not waiting.poll(None if timeout is None else 1000 * timeout):
                    raise subprocess.TimeoutExpired(f"process {self.pid}", timeout or 0)
                os.close(self._descriptor)
                self._descriptor = -1
            self.returncode = self._server.status(self.pid)
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._descriptor, number)

    def terminate(self) -> None:
        """Send SIGTERM."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """Send SIGKILL."""
        self.send_signal(signal.SIGKILL)


class Server:
    """A process that forks, as its test process sees it."""

    def __init__(self, line: socket.socket) -> None:
        self._line = line
        self._lock = threading.Lock()
        self._path = _folders(os.environ)

    def fork(self, argv: Sequence[str], env: Mapping[str, str], out: int) -> Forked:
        """Return a fork that runs `python -m ...`; `out`: the descriptor that it writes to."""
        asked = {"name": argv[2], "argv": list(argv[2:]), "env": dict(env), "folder": str(ROOT)}
        asked |= {"path": self._added(env)}
        return Forked(int(self._ask(json.dumps(asked).encode(), [out])), self)

    def status(self, pid: int) -> int:
        """Return the exit status of a fork that has ended."""
        return os.waitstatus_to_exitcode(int(self._ask(ENDED + b"%d" % pid, [])))

    def close(self) -> None:
        """End it, and with it every fork that still runs."""
        self._line.close()

    def _added(self, env: Mapping[str, str]) -> list[str]:
        return [folder for folder in _folders(env) if folder not in self._path]

    def _ask(self, asked: bytes, files: list[int]) -> bytes:
        with self._lock:
            socket.send_fds(self._line, [asked], files)
            answer = self._line.recv(64)
        if not answer:
            raise OSError("the forking process is gone")
        return answer


class First(Server):
    """The one that has loaded libraries; `loaded` forks of it have loaded our modules, too."""

    def __init__(self) -> None:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        super().__init__(ours)
        with theirs:
            argv = [sys.executable, "-m", "tests.forks", str(theirs.fileno())]
            self._process = subprocess.Popen(argv, cwd=ROOT, pass_fds=[theirs.fileno()], start_new_session=True)
        self._env = {name: os.environ.get(name) for name in SAME}
        self._loaded: Server | None = None
        self._settings: dict[str, str] = {}  # the environment with which it has read them

    def loaded(self, argv: Sequence[str], env: Mapping[str, str]) -> "Server":
        """Return which of both a process is a fork of."""
        settings = {name: value for name, value in env.items() if name not in forks.PER_PROCESS}
        if argv[2] not in LOADED_FOR or (self._loaded is not None and settings != self._settings):
            return self
        if self._loaded is None:
            ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            with theirs:
                self._ask(LOAD + json.dumps(settings).encode(), [theirs.fileno()])
            self._loaded, self._settings = Server(ours), settings
        return self._loaded

    def serves(self, argv: Sequence[str], env: Mapping[str, str]) -> bool:
        """Tell whether a fork is the same as this command with this environment."""
        ours = list(argv[:2]) == [sys.executable, "-m"] and self._process.poll() is None
        hidden = {file.stem for folder in self._added(env) for file in Path(folder).iterdir()} & LOADED
        return ours and not hidden and all(env.get(name) == value for name, value in self._env.items())

    def close(self) -> None:
        """End both, and with them every fork that still runs."""
        if self._loaded is not None:
            self._loaded.close()
        super().close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()


_server: list[First] = []


def close() -> None:
    """End the process that forks, if there is one."""
    while _server:
        _server.pop().close()


def start(argv: Sequence[str], env: Mapping[str, str], out: int) -> "Forked | subprocess.Popen[bytes]":
    """Start a process in a session of its own that writes to the descriptor `out`."""
    if not _server and sys.platform == "linux":
        _server.append(First())
    if _server and _server[0].serves(argv, env):
        return _server[0].loaded(argv, env).fork(argv, env, out)
    return subprocess.Popen(argv, cwd=ROOT, env=env, stdout=out, stderr=subprocess.STDOUT, start_new_session=True)


def main() -> None:
    """Fork for each request of the test process that holds the other end of this line."""
    line = socket.socket(fileno=int(sys.argv[1]))
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # threads do not survive a fork
    forks.load(LIBRARIES)
    forks.freeze()
    _serve(line)


def _serve(line: socket.socket) -> NoReturn:
    if len(list(Path("/proc/self/task").iterdir())) > 1:
        sys.exit("a library has started a thread, which a fork would not have")
    ended: dict[int, int] = {}
    signal.signal(signal.SIGCHLD, lambda *_: _reap(ended))
    server = os.getpid()
    while True:
        asked, files, _, _ = socket.recv_fds(line, forks.MESSAGE, 1)
        if not asked:
            os._exit(0)
        if asked.startswith(ENDED):
            _reap(ended)
            line.send(b"%d" % ended[int(asked.removeprefix(ENDED))])
        elif made := os.fork():
            os.close(files[0])
            line.send(b"%d" % made)
        else:
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            line.close()
            if asked.startswith(LOAD):
                _load(json.loads(asked.removeprefix(LOAD)))
                _serve(socket.socket(fileno=files[0]))
            wanted = json.loads(asked)
            sys.path[1:1] = wanted["path"]
            forks.become(wanted, files[0], server)


def _load(env: dict[str, str]) -> None:
    os.environ.clear()
    os.environ.update(env)
    forks.load_all()


def _folders(env: Mapping[str, str]) -> list[str]:
    """Return the folders of modules that an environment names, as the interpreter reads them."""
    return [str(Path(folder).resolve()) for folder in env.get("PYTHONPATH", "").split(os.pathsep) if folder]


def _reap(ended: dict[int, int]) -> None:
    with contextlib.suppress(ChildProcessError):
        while (pid_and_status := os.waitpid(-1, os.WNOHANG))[0]:
            ended.update([pid_and_status])


if __name__ == "__main__":
    main()
