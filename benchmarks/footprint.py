"""What the whole portal costs while nobody watches: CPU and memory of each process, beside an idle OctoPrint server.

Memory is the proportional set size (PSS): a page that several processes share counts once.
"""

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks._beside import environment
from benchmarks.stage import tell

ROOT = Path(__file__).resolve().parent.parent
SETTLE_S = 20.0  # after both robots are ready: the last imports, the first still pictures
MEASURE_S = float(os.environ.get("FARHAND_BENCH_S", "60"))
START_S = 180.0
OWNER_CPU, OWNER_MB, WHOLE_CPU, WHOLE_MB = 1.0, 80.0, 8.0, 500.0  # % of a core, MB
TICK_S = 1 / os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Cost:
    """CPU (% of a core) and memory (MB, PSS) of a process."""

    name: str
    cpu: float
    mb: float


def main() -> None:
    """Measure both in the same minute."""
    folder = Path(tempfile.mkdtemp(prefix="footprint-"))
    try:
        with _octoprint(folder / "octoprint") as peer, _portal(folder / "var") as ours:
            time.sleep(SETTLE_S)
            before, begun = {pid: _cpu_s(pid) for pid in (*_tree(ours), *_tree(peer))}, time.monotonic()
            time.sleep(MEASURE_S)
            seconds = time.monotonic() - begun
            mine, theirs = (_costs(pid, before, seconds) for pid in (ours, peer))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    for cost in (*sorted(mine, key=lambda c: -c.cpu), _total("whole portal", mine), _total("OctoPrint, idle", theirs)):
        print(f"{cost.name:32} {cost.cpu:6.2f} % of a core {cost.mb:7.1f} MB")
    _judge(mine, theirs)


def _judge(mine: list[Cost], theirs: list[Cost]) -> None:
    """Print the last line."""
    whole, peer = _total("whole", mine), _total("OctoPrint", theirs)
    owners = [c for c in mine if c.name.startswith("owner")]
    cpu, mb = max(c.cpu for c in owners), max(c.mb for c in owners)
    tell(
        "footprint", whole.cpu, "% of a core, the whole portal, nobody watching",
        f"whole <= {WHOLE_CPU:g} % and {WHOLE_MB:g} MB, an owner <= {OWNER_CPU:g} % and {OWNER_MB:g} MB",
        whole.cpu <= WHOLE_CPU and whole.mb <= WHOLE_MB and cpu <= OWNER_CPU and mb <= OWNER_MB,
        {
            "whole_mb": round(whole.mb), "owner_cpu": round(cpu, 2), "owner_mb": round(mb),
            "octoprint_cpu": round(peer.cpu, 2), "octoprint_mb": round(peer.mb),
        },
    )  # fmt: skip


def _total(name: str, costs: list[Cost]) -> Cost:
    return Cost(name, sum(c.cpu for c in costs), sum(c.mb for c in costs))


# processes


def _tree(root: int) -> list[int]:
    """Return the process and all that it has begun."""
    parents = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with contextlib.suppress(OSError):
                parents[int(entry.name)] = int(_stat(int(entry.name))[1])
    found = [root]
    for pid in found:
        found.extend(child for child, parent in parents.items() if parent == pid)
    return found


def _stat(pid: int) -> list[str]:
    """Return the fields of /proc/PID/stat from the state on."""
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()


def _cpu_s(pid: int) -> float:
    """Return the CPU time of a process and of its children that have ended (s)."""
    return sum(map(int, _stat(pid)[11:15])) * TICK_S


def _costs(root: int, before: dict[int, float], seconds: float) -> list[Cost]:
    costs = []
    for pid in _tree(root):
        with contextlib.suppress(OSError):  # it has ended meanwhile: its parent's time holds it
            cpu = 100 * (_cpu_s(pid) - before.get(pid, 0.0)) / seconds
            rollup = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
            kb = next(int(line.split()[1]) for line in rollup if line.startswith("Pss:"))
            costs.append(Cost(_name(pid), cpu, kb * 1024 / 1e6))
    return costs


def _name(pid: int) -> str:
    """Return what a reader calls the process."""
    comm = Path(f"/proc/{pid}/comm").read_text().strip()
    if comm.endswith(("worker", "work", "wor")):
        return f"owner {comm.rpartition(' ')[0]}"
    argv = Path(f"/proc/{pid}/cmdline").read_text().split("\0")
    settings = dict(part.partition("=")[::2] for part in Path(f"/proc/{pid}/environ").read_text().split("\0"))
    if robot := settings.get("FARHAND_ROBOT"):
        return f"owner {robot}"
    module = argv[argv.index("-m") + 1] if "-m" in argv else ""
    if not comm.startswith("python"):
        return comm
    if module.startswith("simulators"):
        return f"simulator {module.removeprefix('simulators.')}"
    if "manage.py" in argv:
        return "supervisor"
    return settings.get("FARHAND_ROLE") or Path(argv[0].split()[0]).name


# the two servers


@contextlib.contextmanager
def _running(argv: list[str | Path], env: dict[str, str], log: Path) -> Iterator[int]:
    """Run a process with its output in a file; end it and what it has begun."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("w") as out:
        process = subprocess.Popen(argv, cwd=ROOT, env=env, stdout=out, stderr=out)
        try:
            yield process.pid
        except BaseException:
            print(log.read_text()[-3000:], file=sys.stderr)
            raise
        finally:
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(60)
            except subprocess.TimeoutExpired:
                process.kill()


@contextlib.contextmanager
def _portal(var: Path) -> Iterator[int]:
    """Run the portal as `make run` does, without the robots that roam; yields the supervisor once both are ready."""
    port, var_log = _free_port(), var.with_suffix(".log")
    plain = {k: v for k, v in os.environ.items() if not k.startswith(("FARHAND_", "DATABASE_URL", "REDIS_URL"))}
    argv: list[str | Path] = [sys.executable, "manage.py", "demo", "--port", str(port)]
    with _running(argv, {**plain, "FARHAND_VAR": str(var), "PYTHONPATH": str(ROOT)}, var_log) as pid:
        _wait(lambda: _answers(f"http://127.0.0.1:{port}/livez"), "the portal")
        for slug in ("irat", "rover"):
            _switch_off(var, slug)
        _wait(lambda: _ready(var), "both robots")
        yield pid


def _switch_off(var: Path, slug: str) -> None:
    """Switch a robot off, as staff would; the supervisor ends its processes."""
    import sqlite3

    with contextlib.closing(sqlite3.connect(var / "farhand.sqlite3", timeout=20)) as store, store:
        store.execute("UPDATE robots_robot SET enabled = 0 WHERE slug = ?", (slug,))


def _ready(var: Path) -> bool:
    import sqlite3

    with contextlib.closing(sqlite3.connect(f"file:{var / 'farhand.sqlite3'}?mode=ro", uri=True, timeout=20)) as store:
        cycles = [cycle for (cycle,) in store.execute("SELECT cycle FROM robots_robot WHERE enabled")]
    return bool(cycles) and all(cycle == "ready" for cycle in cycles)


@contextlib.contextmanager
def _octoprint(folder: Path) -> Iterator[int]:
    """Run OctoPrint with no printer; yields its process once it serves."""
    octoprint, port = environment("octoprint") / "bin" / "octoprint", _free_port()
    argv: list[str | Path] = [
        octoprint, "serve", "--iknowwhatimdoing", "--host", "127.0.0.1", "--port", str(port), "--basedir", folder
    ]  # fmt: skip
    with _running(argv, dict(os.environ), folder.with_suffix(".log")) as pid:
        _wait(lambda: _answers(f"http://127.0.0.1:{port}/"), "OctoPrint")
        yield pid


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=2):
            return True
    except urllib.error.HTTPError as error:
        return error.code < 500
    except OSError:
        return False


def _wait(done: Callable[[], bool], what: str) -> None:
    until = time.monotonic() + START_S
    while not done():
        if time.monotonic() > until:
            sys.exit(f"{what} did not come up within {START_S:g} s")
        time.sleep(0.5)
