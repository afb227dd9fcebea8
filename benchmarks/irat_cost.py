"""What the iRat's simulator costs: roaming with its driver, and docked with its owner connected and nobody watching.

The driver and its brain run beside it in processes of their own; what they cost is printed, not judged. `FARHAND_BENCH_S`
is how long each of the two is measured (s).
"""

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

from benchmarks.stage import set_up, tell

MEASURE_S = float(os.environ.get("FARHAND_BENCH_S", "60"))
SETTLE_S, START_S = 10.0, 180.0
ROAMING, DOCKED = 40.0, 3.0  # % of a core
TICK_S = 1 / os.sysconf("SC_CLK_TCK")


class Over(Exception):
    """The measurement is over."""


def main() -> None:
    """Measure the simulator in both states."""
    set_up()
    folder = Path(tempfile.mkdtemp(prefix="irat-cost-"))
    simulator = subprocess.Popen([sys.executable, "-m", "simulators.irat", "--dir", folder, "--port", "0"])
    try:
        found = _measured(folder, simulator)
    finally:
        simulator.terminate()
        simulator.wait()
        shutil.rmtree(folder, ignore_errors=True)
    tell(
        "irat_cost", found["roaming"], "% of a core, the simulator while it roams",
        f"<= {ROAMING:g} roaming, <= {DOCKED:g} docked and unwatched",
        found["roaming"] <= ROAMING and found["docked"] <= DOCKED, found,
    )  # fmt: skip


def _measured(folder: Path, simulator: "subprocess.Popen[bytes]") -> dict[str, Any]:
    from robots.kit.drivers.irat.driver import Driver
    from tests.rig import Board

    _until((folder / "tty").exists, "the simulator's address")
    board = Board(folder)
    driver = Driver((folder / "tty").read_text().strip(), {"epoch": 1, "folder": folder / "owner"})
    driver.connect()
    try:
        over = threading.Event()
        roaming = threading.Thread(target=_roam, args=(driver, over))
        roaming.start()
        _until(lambda: board.status()["moving"] and not driver.senses.charging, "roaming")
        time.sleep(SETTLE_S)
        before = board.status()["driven"]
        costs = {"roaming": _share(simulator.pid, driver.brain.pid)}
        metres = board.status()["driven"] - before
        over.set()
        roaming.join()
        board.fault("carried", -1)
        _until(lambda: board.status()["contacts"] == [True, True] and driver.senses.charging, "the dock")
        time.sleep(SETTLE_S)
        costs["docked"] = _share(simulator.pid, driver.brain.pid)
        assert board.status()["charging"] and not board.status()["moving"]
    finally:
        driver.close()
    named = {name: round(simulated, 2) for name, (simulated, _, _) in costs.items()}
    beside = {
        f"{who}_{name}": round(shares[place], 2)
        for name, shares in costs.items()
        for place, who in ((1, "driver"), (2, "brain"))
    }
    return {**named, **beside, "metres": round(metres, 2), "seconds": MEASURE_S}


def _roam(driver: Any, over: threading.Event) -> None:
    """Explore, slice after slice."""

    def permit() -> None:
        if over.is_set():
            raise Over

    with contextlib.suppress(Over):
        while True:
            driver.execute("explore", {}, permit, lambda _: None)


def _share(simulator: int, brain: int) -> tuple[float, float, float]:
    """Return what simulator, driver and brain use of a core (%)."""
    pids = (simulator, os.getpid(), brain)
    before, began = [_cpu_s(pid) for pid in pids], time.monotonic()
    time.sleep(MEASURE_S)
    took = time.monotonic() - began
    simulated, driver, thought = (100 * (_cpu_s(pid) - was) / took for pid, was in zip(pids, before, strict=True))
    return simulated, driver, thought


def _cpu_s(pid: int) -> float:
    """Return the CPU time of a process (s)."""
    return sum(map(int, Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:13])) * TICK_S


def _until(holds: Any, what: str) -> None:
    end = time.monotonic() + START_S
    while not holds():
        if time.monotonic() > end:
            raise TimeoutError(what)
        time.sleep(0.2)


if __name__ == "__main__":
    main()
