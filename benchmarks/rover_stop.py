"""The rover's stop while pictures are on their way: from the hold to the rest that its simulator notes.

The real process over TCP, driven at its greatest speed, 8 pictures a second asked for beside. Holds come at random
moments. Both ends read the machine's one monotonic clock.
"""

import json
import random
import tempfile
import threading
import time
from pathlib import Path

from benchmarks.stage import percentile, set_up, tell

STOPS, MOST_S, SHARE = 150, 0.300, 0.99


def main() -> None:
    """Stop again and again; judge by the simulator's journal."""
    set_up()
    from tests.rig import RoverSimulator

    with tempfile.TemporaryDirectory() as folder:
        simulator = RoverSimulator(Path(folder))
        try:
            stops = measured(Path(folder))
        finally:
            simulator.stop()
    rests = sorted(stops)
    print(f"{len(rests)} stops: median {1000 * rests[len(rests) // 2]:.0f} ms, slowest {1000 * rests[-1]:.0f} ms")
    share = sum(one <= MOST_S for one in rests) / len(rests)
    beside = {"median_ms": round(1000 * rests[len(rests) // 2]), "99_ms": round(1000 * percentile(rests, 0.99))}
    tell("rover_stop", round(share, 3), f"of {STOPS} at rest within 300 ms", f">= {SHARE}", share >= SHARE, beside)


def measured(folder: Path) -> list[float]:
    """Return for each stop how long it took until the simulator noted the rest (s)."""
    from robots.kit.contract.errors import RobotError
    from robots.kit.drivers.srv1.driver import Driver

    driver, dice, over = Driver(str(folder / "tty"), {"epoch": 1}), random.Random(1), threading.Event()
    driver.connect()

    def film() -> None:
        while not over.is_set():
            driver.picture("rover", 1.0)
            over.wait(0.125)

    threading.Thread(target=film, daemon=True).start()
    told: list[float] = []
    journal = folder / "journal.jsonl"
    for number in range(STOPS):
        way = 1.0 if number % 2 else -1.0

        def drive(forward: float = way) -> None:
            try:
                driver.execute("drive", {"forward": forward, "turn": 0.3}, lambda: None, lambda stage: None)
            except RobotError:
                return

        runs = threading.Thread(target=drive)
        runs.start()
        time.sleep(0.9 + dice.random() * 0.4)
        at = time.monotonic()
        driver.hold()
        runs.join()
        notes = [json.loads(line) for line in journal.read_text().splitlines()]
        rest = next((note["t"] for note in reversed(notes) if note["event"] == "rest"), None)
        if rest is not None and rest >= at:
            told.append(rest - at)
    over.set()
    driver.close()
    return told


if __name__ == "__main__":
    main()
