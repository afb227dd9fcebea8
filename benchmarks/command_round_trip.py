"""From the console's socket to the owner and back, beside a bare Celery task in the same run."""

import json
import os
import subprocess
import sys
import time
from datetime import timedelta
from pathlib import Path
from typing import Any

from benchmarks.stage import again, cast, database, median, percentile, set_up, tell

ROOT = Path(__file__).resolve().parent.parent
RUNS = 300
MEDIAN, MOST = 2.5, 7.0  # times the bare task: the median, and 99 %
MOST_MS = 200  # of 99 %: what people take for an answer at once
WANTED = f"median <= {MEDIAN:g}, 99 % <= {MOST:g} and {MOST_MS} ms"
WARM = 30


def main() -> None:
    """Measure on the database of this process; the outer process does both."""
    wanted = os.environ.get("FARHAND_BENCH_DB")
    if wanted is None:
        found = {name: again(name) for name in ("sqlite", "postgres")}
        worst = max(f["value"] for f in found.values())
        holds = all(f["holds"] for f in found.values())
        beside = {name: f["beside"] for name, f in found.items()}
        tell(
            "command_round_trip",
            worst,
            "times a bare Celery task, median, the worse database",
            WANTED,
            holds,
            beside,
        )
        return
    set_up(wanted)
    with database():
        ours, bare = _measure()
    ratio, ratio99 = median(ours) / median(bare), percentile(ours, 0.99) / median(bare)
    print(
        f"ours {median(ours):.2f} ms, 99 % {percentile(ours, 0.99):.2f} ms; bare task {median(bare):.2f} ms, 99 % {percentile(bare, 0.99):.2f} ms"
    )
    beside = {
        "ours_ms": round(median(ours), 2),
        "ours_99_ms": round(percentile(ours, 0.99), 2),
        "bare_ms": round(median(bare), 2),
        "ratio_99": round(ratio99, 2),
    }
    tell(
        "command_round_trip",
        ratio,
        f"times a bare Celery task, median, {wanted}",
        WANTED,
        ratio <= MEDIAN and ratio99 <= MOST and percentile(ours, 0.99) <= MOST_MS,
        beside,
    )


def _measure() -> tuple[list[float], list[float]]:
    from robots import services
    from robots.kit.clock import SYSTEM
    from robots.models import Robot
    from robots.states import Cycle, GrantKind
    from tests.conftest import RedisServer, wait_for
    from tests.rig import Simulator, Web, child_env, worker

    redis = RedisServer()
    redis.start()
    robot, person = cast()
    sim = Simulator(robot.rig_dir)
    owner, web = worker(), Web()
    plain = {k: v for k, v in child_env().items() if k != "DJANGO_SETTINGS_MODULE"}
    bare = subprocess.Popen(
        [sys.executable, "-m", "celery", "-q", "-A", "benchmarks.bare", "worker", "--pool", "threads", "--concurrency", "1", "-Q", "bare",
         "--without-gossip", "--without-mingle", "--without-heartbeat", "-l", "ERROR"],
        cwd=ROOT, env=plain, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        wait_for(lambda: Robot.objects.get().cycle == Cycle.READY, 60, "the robot")
        now = SYSTEM.now()
        Robot.objects.update(cycle=Cycle.OPERATING)
        services.start_grant(robot, GrantKind.TURN, now, person, now + timedelta(minutes=30))
        return _ours(web, person), _bare(plain)
    finally:
        web.kill()
        owner.kill()
        bare.kill()
        sim.stop()
        redis.stop()


def cookie(person: Any) -> str:
    """Return the Cookie header of a new session of `person`."""
    from django.conf import settings
    from django.contrib.auth import BACKEND_SESSION_KEY, HASH_SESSION_KEY, SESSION_KEY
    from django.contrib.sessions.backends.db import SessionStore

    store = SessionStore()
    store[SESSION_KEY], store[HASH_SESSION_KEY] = str(person.pk), person.get_session_auth_hash()
    store[BACKEND_SESSION_KEY] = "accounts.backends.ConstantTimeBackend"
    store.save()
    return f"{settings.SESSION_COOKIE_NAME}={store.session_key}"


def _ours(web: Any, person: Any) -> list[float]:
    from websockets.sync.client import connect

    times = []
    with connect(
        f"{web.url.replace('http', 'ws')}/ws/robots/mercury/",
        additional_headers={"Cookie": cookie(person)},
        origin=web.url,
    ) as socket:
        for seq in range(1, RUNS + WARM + 1):
            begun = time.perf_counter()
            socket.send(json.dumps({"t": "command", "kind": "noop", "args": {}, "seq": seq}))
            while True:
                data = socket.recv(timeout=10)
                if isinstance(data, bytes):
                    continue
                message = json.loads(data)
                assert not (message["t"] == "answer" and not message["ok"]), message
                if message["t"] == "command" and message["seq"] == seq and message["state"] == "completed":
                    break
            times.append((time.perf_counter() - begun) * 1000)
            time.sleep(0.055)  # the socket's rate limit is 20 a second
    return times[WARM:]


def _bare(env: dict[str, str]) -> list[float]:
    """Run the client of the bare task in a process of its own, free of Django."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.bare", str(RUNS + WARM)],
        cwd=ROOT,
        env=env,
        capture_output=True,
        text=True,
        check=True,
    )
    times: list[float] = json.loads(done.stdout)
    return times[WARM:]
