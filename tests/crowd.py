"""A crowd of viewers in a process of its own."""

import contextlib
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MANY = {"FARHAND_SOCKETS_PER_ADDRESS": "5000", "FARHAND_CONNECTIONS_PER_ADDRESS": "5000"}


class Crowd:
    """`viewers` who watch a robot; each `watch` tells what they saw during so many seconds."""

    def __init__(self, url, viewers, seconds, *options, slug="mercury"):
        where = f"{url}/ws/robots/{slug}/"
        argv = [sys.executable, "-m", "benchmarks._crowd", where, str(viewers), str(seconds), *options]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(argv, cwd=ROOT, text=True, stdin=pipe, stdout=pipe)
        assert self._said()["joined"] <= viewers
        self._go_on()
        assert self._said()["joined"] == viewers

    def begin(self):
        """Have them watch from now on."""
        self._go_on()

    def seen(self):
        """Return what they saw since `begin`, once the time is over."""
        return self._said()

    def watch(self):
        """Have them watch; return what they saw."""
        self.begin()
        return self.seen()

    def _said(self):
        line = self._process.stdout.readline()
        assert line, "the crowd ended; what went wrong is above"
        return json.loads(line)

    def _go_on(self):
        self._process.stdin.write("\n")
        self._process.stdin.flush()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        with self._process:  # closes its pipes
            self._process.kill()


@contextlib.contextmanager
def publishing(store):
    """Have a process publish a picture of 6 kB ten times a second as Mercury's."""
    with subprocess.Popen([sys.executable, "-m", "benchmarks._fans", "publish", "ours", store], cwd=ROOT) as process:
        try:
            yield
        finally:
            process.kill()
