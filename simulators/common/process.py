"""Arguments and stop of a simulator's process."""

import argparse
import signal
from pathlib import Path
from typing import Any, Protocol


class Stoppable(Protocol):
    """A simulator that runs."""

    def stop(self, *_: Any) -> None:
        """End the loop; may be called from a signal handler."""


def arguments(about: str | None) -> argparse.ArgumentParser:
    """Return a parser with `--dir`, the folder of address, faults, journal and state, and `--speed`, for `Timer`."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--dir", type=Path, required=True)
    parser.add_argument("--speed", type=float, default=1.0, help="how many times faster than real time it runs")
    return parser


def stop_when_told(simulator: Stoppable) -> None:
    """Stop on SIGTERM and on Ctrl-C."""
    signal.signal(signal.SIGTERM, simulator.stop)
    signal.signal(signal.SIGINT, simulator.stop)
