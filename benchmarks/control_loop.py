"""Share of the museum arm's 500 Hz steps that are on time, with three cameras watched; tracking error of both controllers."""

import os
import sys
from typing import Any

from benchmarks.stage import set_up, tell

SECONDS = float(os.environ.get("SECONDS", "30"))  # of each row
ORDINARY = (sys.executable, "-m", "benchmarks._ordinary")
GOAL = 0.99
TARGETS = ((60, 40, 60, 20, 60, 40), (-50, 10, 90, -30, 100, -60), (0, 25, 75, 0, 80, 0), (30, 0, 100, 60, 40, 90))


def main() -> None:
    """Drive while three readers take every picture they can get, at 5 a second each."""
    set_up()
    judged = {
        "computed_torque": _measure("computed_torque"),
        "computed_torque_ordinary_user": _measure("computed_torque", ORDINARY),
    }
    rows = {**judged, "pd": _measure("pd")}
    for name, row in rows.items():
        print(name, row)
    share = min(row["on_time"] for row in judged.values())
    unit = "of 500 Hz steps begun within 2 ms, with real-time priority and without, the lesser"
    tell("control_loop", share, unit, f"{GOAL:.2f}", share >= GOAL, rows)


def _measure(controller: str, before: tuple[str, ...] = ()) -> dict[str, Any]:
    import contextlib
    import json
    import tempfile
    import threading
    import time
    import urllib.request
    from pathlib import Path

    import numpy as np

    from robots.kit.contract.find import spec_of
    from robots.kit.drivers.pa10.driver import Driver
    from tests.conftest import wait_for
    from tests.rig import ArmSimulator

    with tempfile.TemporaryDirectory() as folder:
        sim = ArmSimulator(Path(folder), before, controller=controller)
        running, pictures = True, [0, 0, 0]

        def look(index: int, address: str) -> None:
            due = time.monotonic()
            while running:
                due += 0.2
                with contextlib.suppress(OSError):  # the camera goes when the run ends
                    urllib.request.urlopen(f"{address}/snapshot.jpg", timeout=10).read()
                    pictures[index] += 1
                time.sleep(max(0.0, due - time.monotonic()))

        try:
            wait_for((sim.folder / "cameras.json").exists, 20, "the cameras")
            addresses = json.loads((sim.folder / "cameras.json").read_text()).values()
            for index, address in enumerate(addresses):
                threading.Thread(target=look, args=(index, address), daemon=True).start()
            arm = Driver(str(sim.folder / "tty"), {"epoch": 1})
            arm.connect()
            policy = os.sched_getscheduler(sim.process.pid) & ~os.SCHED_RESET_ON_FORK
            first, begun = sim.status(), time.monotonic()
            number = 0
            while time.monotonic() - begun < SECONDS:
                target = dict(
                    zip(spec_of("pa10").joints[:6], np.radians(TARGETS[number % len(TARGETS)]).tolist(), strict=True)
                )
                arm.execute("joints", target, lambda: None, lambda _: None)
                number += 1
            seconds, last = time.monotonic() - begun, sim.status()
            running = False
            arm.close()
        finally:
            sim.stop()
    steps = last["steps"] - first["steps"]
    late = last["late"] - first["late"]
    return {
        "real_time_priority": policy == os.SCHED_RR,
        "on_time": round(1 - late / steps, 5), "worst_ms": last["worst_ms"], "steps": steps, "motions": number,
        "hz": round(steps / seconds, 1), "worst_error_rad": last["worst_error"],
        "pictures_a_second": round(min(pictures) / seconds, 2),
    }  # fmt: skip


if __name__ == "__main__":
    main()
