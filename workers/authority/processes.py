"""The processes that own robots, as the kernel of this machine knows them."""

import contextlib
import logging
import os
import signal
import socket
from dataclasses import dataclass
from pathlib import Path

from robots.models import Lease

log = logging.getLogger(__name__)


def process_start(pid: int) -> str:
    """Return the process's start time as the kernel gives it; empty if there is no such process."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return ""
    return text.rpartition(")")[2].split()[19]


@dataclass(frozen=True)
class Process:
    """A process of some machine: its host, its number, and when it was started as its kernel gives it."""

    host: str
    pid: int
    started: str


class Processes:
    """Says which process this is, whether a lease's lives, and kills that."""

    @property
    def own(self) -> Process:
        """Return this process."""
        pid = os.getpid()
        return Process(socket.gethostname(), pid, process_start(pid))

    def _lives(self, pid: int, started: str) -> bool:
        return bool(started) and process_start(pid) == started

    def _kill(self, pid: int, started: str) -> None:
        with contextlib.suppress(ProcessLookupError):
            descriptor = os.pidfd_open(pid)
            try:
                if self._lives(pid, started):
                    signal.pidfd_send_signal(descriptor, signal.SIGKILL)
            finally:
                os.close(descriptor)

    def owner_gone(self, lease: Lease) -> bool:
        """Return whether the lease's process is known to own the robot no more.

        It gave the lease back, or ran on this host and has ended, or is the one that asks.
        """
        if not lease.pid:
            return True
        own = self.own
        return lease.host == own.host and (lease.pid == own.pid or not self._lives(lease.pid, lease.started))

    def kill_recorded_owner(self, lease: Lease) -> None:
        """Kill the process that the lease names, if the same process still runs on this host."""
        own = self.own
        if lease.host != own.host or not lease.pid or lease.pid == own.pid:
            return
        if self._lives(lease.pid, lease.started):
            log.warning("killing the frozen owner %s of epoch %s", lease.pid, lease.epoch)
            self._kill(lease.pid, lease.started)
