"""What each simulator has as a program: where its folder is, and who tells it to stop."""

import argparse
import signal
from pathlib import Path
from typing import Any, Protocol


class Stoppable(Protocol):
    """A simulator that runs."""

    def stop(self, *_: Any) -> None:
        """Leave the loop; may be called from a signal handler."""


def arguments(about: str | None) -> argparse.ArgumentParser:
    """Return a parser with `--dir`, where address, faults, journal and state are kept."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--dir", type=Path, required=True)
    return parser


def stop_when_told(simulator: Stoppable) -> None:
    """Stop on SIGTERM and on Ctrl-C."""
    signal.signal(signal.SIGTERM, simulator.stop)
    signal.signal(signal.SIGINT, simulator.stop)
