"""Compile the cameras' loops, once after an installation: `python -m simulators.srv1.prepare`."""

import numpy as np

from simulators.srv1.cameras import Overhead, RoverCamera, stage

if __name__ == "__main__":
    RoverCamera(stage()).take(np.eye(4))
    Overhead(stage()).take(np.eye(4))
