"""Arguments, start and stop of a simulator's process."""

import argparse
import gc
import signal
import sys
from pathlib import Path
from typing import Any, Protocol


class Runnable(Protocol):
    """A simulator."""

    def run(self) -> None:
        """Let time pass until stopped."""

    def stop(self, *_: Any) -> None:
        """End the loop; may be called from a signal handler."""


def arguments(about: str | None) -> argparse.ArgumentParser:
    """Return a parser with `--dir`, the folder of address, faults, journal and state, and `--speed`, for `Timer`."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--dir", type=Path, required=True)
    parser.add_argument("--speed", type=float, default=1.0, help="how many times faster than real time it runs")
    return parser


def run(simulator: Runnable, greeting: str) -> None:
    """Print a line, then run until stopped. Objects so far stay: to collect them would take longer than a step."""
    stop_at_signals(simulator)
    sys.stdout.write(f"{greeting}\n")
    sys.stdout.flush()
    gc.collect()
    gc.freeze()
    simulator.run()


def stop_at_signals(simulator: Runnable) -> None:
    """Stop on SIGTERM and on Ctrl-C."""
    signal.signal(signal.SIGTERM, simulator.stop)
    signal.signal(signal.SIGINT, simulator.stop)
