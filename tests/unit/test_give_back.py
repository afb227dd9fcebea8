"""A simulator's camera gives back the memory of its pictures once nobody takes any."""

import subprocess
import sys

import pytest

from tests.rig import ROOT

PICTURES = """
import time
from urllib.request import urlopen
import numpy as np
from simulators.common import camera_server
from simulators.common.faults import FaultBoard

def resident_mb():
    return int(open("/proc/self/statm").read().split()[1]) * 4096 / 1e6

held = []

def take(exposure):
    parts = [np.ones(10_000, np.uint8) for _ in range(5_000)]
    held.append(parts[-1])  # lies above the others, so that the heap cannot shrink by itself
    return np.zeros((16, 16), np.uint8)

camera_server.IDLE_S = float("inf")
camera = camera_server.CameraServer(take, FaultBoard(1), (0.001, 0.1))
urlopen(f"http://127.0.0.1:{camera.port}/snapshot.jpg").read()
before = resident_mb()
camera_server.IDLE_S = 0.5
until = time.monotonic() + 60
while resident_mb() > before - 30 and time.monotonic() < until:
    time.sleep(0.1)
print(before - resident_mb())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="asks glibc")
def test_memory_of_pictures_is_given_back():
    done = subprocess.run(
        [sys.executable, "-c", PICTURES], cwd=ROOT, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) > 30, "of 50 MB"
