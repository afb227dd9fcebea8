"""Starts processes as forks of one process that has loaded their modules, so that memory holds these once.

Our processes import 90 MB of modules; forks share that memory as long as no process writes to it. The supervisor loads
all of it and reads the settings, then forks a process that only forks. A process whose environment differs from the
supervisor's in `PER_PROCESS` reads these variables after the fork; with any other difference it is started in the
ordinary way.
Linux only: the kernel gives each fork to the supervisor, which waits for it as for any child. On other systems, or if
the forking process has ended, processes are started in the ordinary way.
"""

import asyncio
import contextlib
import ctypes
import gc
import json
import os
import runpy
import signal
import socket
import sys
import threading
import time
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from portal.run import gaps, roles

LIBRARIES = (
    "django.db.backends.sqlite3.base", "django.db.models.sql.compiler", "django.core.management", "django.test.signals",
    "django.core.handlers.asgi", "django.contrib.messages.storage.session", "django.contrib.sessions.serializers",
    "celery.apps.worker", "celery.bin.celery", "celery.bin.worker", "celery.concurrency.thread", "celery.beat",
    "celery.app.control", "celery.app.log", "celery.backends.base", "celery.contrib.django.task",
    "celery.events.receiver", "celery.worker.autoscale", "celery.worker.components", "celery.worker.consumer",
    "celery.worker.consumer.delayed_delivery", "celery.worker.strategy", "kombu.transport.redis", "kombu.mixins",
    "billiard.pool", "uvicorn", "uvicorn.protocols.http.h11_impl", "uvicorn.lifespan.off", "uvloop", "redis.asyncio",
    "channels.generic.websocket", "msgspec", "ssl", "encodings.idna", "importlib.resources.readers", "dbm.dumb",
    "numpy", "cv2", "scipy.spatial.transform", "av",
)  # fmt: skip
OURS = (  # not those that are run: `python -m` loads these again
    "portal.celery", "portal.urls", "portal.edge.protocols", "portal.live.robot_socket", "portal.edge.origins",
    "portal.live.person_socket", "portal.edge.requests", "portal.edge.pages",
    "portal.edge.cache", "portal.management.commands.demo", "portal.keep.seeding", "queueing.tasks",
    "workers.process.tasks",
    "workers.process.bootstep", "workers.process.wiring", "workers.recorder.recorder", "portal.broadcast.following",
    "portal.broadcast.serving", "portal.management.broadcasting",
)  # fmt: skip
PER_PROCESS = frozenset(
    {"FARHAND_ROLE", "FARHAND_ROBOT", "FARHAND_SCHEDULE", "PYTHONWARNINGS", "CELERY_SKIP_CHECKS"}
)  # read in each process, or by `become`
PR_SET_PDEATHSIG, PR_SET_NAME, PR_SET_CHILD_SUBREAPER, M_ARENA_MAX = 1, 15, 36, -8
ADOPTED_S = 5.0  # a fork waits this long to become a child of the supervisor
ANSWER_S = 20.0  # longer than a fork takes on a busy machine
MESSAGE = 200_000  # bytes of a request: arguments and environment

_line: socket.socket | None = None
_environment: dict[str, str] = {}  # with which everything was loaded
_asking = threading.Lock()  # one request and its answer at a time


def prepare() -> None:
    """Load everything and start the process that forks; called first, while there is only one thread."""
    global _line, _environment
    if sys.platform != "linux" or ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0):
        return
    load_all()
    _environment = dict(os.environ)
    if len(list(Path("/proc/self/task").iterdir())) > 1:
        return  # a fork has one thread only, and would wait for what the others have locked
    _line, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    supervisor = os.getpid()
    if os.fork():
        theirs.close()
        return
    _line.close()
    _line = None
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the supervisor, whose end also ends this process
    _rename("farhand forks")
    _serve(theirs, supervisor)


def load_all() -> None:
    """Load libraries, the settings with Django's apps, and our modules; nothing is logged or connected."""
    before = dict(os.environ)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # threads do not survive a fork
    load(LIBRARIES)
    os.environ.clear()
    os.environ.update(before)  # OpenCV adds a folder of libraries, which no other process needs
    from django.apps import apps  # noqa: PLC0415 - the settings are read by it
    from django.conf import settings  # noqa: PLC0415

    apps.populate(settings.INSTALLED_APPS)  # each process configures its log itself
    load(OURS)
    freeze()
    gaps.fill()


def load(names: tuple[str, ...]) -> None:
    """Import what is installed of these."""
    for name in names:
        with contextlib.suppress(ImportError):  # some robots' libraries may not be installed
            import_module(name)


def freeze() -> None:
    """Exclude loaded objects from garbage collection, which writes to them and so ends the sharing of memory."""
    gc.collect()
    gc.freeze()


def _serve(line: socket.socket, supervisor: int) -> NoReturn:
    """Fork for each request; answer with the fork's number, 0 where there is none. End with the supervisor."""
    while True:
        asked, files, _, _ = socket.recv_fds(line, MESSAGE, 1)
        if not asked:
            os._exit(0)
        status = 1
        with contextlib.suppress(OSError):  # the system has no process left for now
            middle = os.fork()
            if not middle:
                _fork_child(line, supervisor, asked, files[0])
            status = os.waitpid(middle, 0)[1]
        os.close(files[0])
        if status:
            line.send(b"0")


def _fork_child(line: socket.socket, supervisor: int, asked: bytes, out: int) -> NoReturn:
    """Fork once more and end, so that the fork becomes the supervisor's child."""
    try:
        made = os.fork()
    except OSError:
        os._exit(1)
    if not made:
        line.close()
        become(json.loads(asked), out, supervisor)
    try:
        line.send(b"%d" % made)
    except OSError:  # the supervisor has given up waiting, and starts it in the ordinary way
        os.kill(made, signal.SIGKILL)
    os._exit(0)


def become(request: dict[str, Any], out: int, parent: int) -> NoReturn:
    """Run as `python -m` would. `request`: name, argv, env, folder; `out`: where it writes; `parent`: its parent."""
    os.setsid()
    until = time.monotonic() + ADOPTED_S
    while os.getppid() != parent and time.monotonic() < until:
        time.sleep(0.001)
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        os._exit(1)
    null = os.open(os.devnull, os.O_RDONLY)
    for have, want in ((null, 0), (out, 1), (out, 2)):
        os.dup2(have, want)
    os.close(out)
    os.close(null)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    ctypes.CDLL(None).mallopt(M_ARENA_MAX, 2)  # a heap for each thread would waste memory
    _rename(request["name"])
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["env"])
    for option in filter(None, request["env"].get("PYTHONWARNINGS", "").split(",")):
        action, _, message = option.partition(":")
        warnings.filterwarnings(action, message)  # type: ignore[arg-type]
    roles.take(request["env"].get("FARHAND_ROLE", "web"))
    module, *arguments = request["argv"]
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)
    sys.exit(0)


def _rename(name: str) -> None:
    """Show this name in `ps` and `top` (15 characters of it)."""
    ctypes.CDLL(None).prctl(PR_SET_NAME, name.encode()[:15], 0, 0, 0)


class Forked:
    """A forked child with the interface of `asyncio.subprocess.Process`."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self.returncode: int | None = None

    async def wait(self) -> int:
        """Return the exit status after it has ended."""
        loop, ended = asyncio.get_running_loop(), asyncio.Event()
        descriptor = os.pidfd_open(self.pid)
        loop.add_reader(descriptor, ended.set)
        try:
            await ended.wait()
        finally:
            loop.remove_reader(descriptor)
            os.close(descriptor)
        self.returncode = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        return self.returncode


async def fork(name: str, argv: tuple[str, ...], env: dict[str, str], folder: Path, out: int) -> Forked | None:
    """Return a fork that runs `python -m ...` with this environment and writes to the descriptor `out`.

    None if it must be started in the ordinary way.
    """
    global _line
    changed = {key for key, _ in env.items() ^ _environment.items()}
    if _line is None or argv[:2] != (sys.executable, "-m") or not changed <= PER_PROCESS:
        return None
    asked = json.dumps({"name": name, "argv": argv[2:], "env": env, "folder": str(folder)}).encode()
    try:
        return Forked(await asyncio.to_thread(_ask, _line, asked, out))
    except TimeoutError:  # it hangs; a fork that it has begun ends with the line
        if _line is not None:
            _line.close()
            _line = None
        return None
    except OSError:
        return None


def _ask(line: socket.socket, asked: bytes, out: int) -> int:
    with _asking:
        line.settimeout(ANSWER_S)
        socket.send_fds(line, [asked], [out])
        answer = line.recv(64)
    if not answer or answer == b"0":
        raise OSError("nothing was forked")
    return int(answer)


def reap(ours: set[int]) -> None:
    """Reap processes that outlived the process that started them.

    Those in `ours` are waited for elsewhere (0: not known yet).
    """
    if _line is None or 0 in ours:
        return
    with contextlib.suppress(ChildProcessError):
        while (ended := os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)) and ended.si_pid not in ours:
            os.waitpid(ended.si_pid, 0)
