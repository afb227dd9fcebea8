"""Compile the loops over pictures, once after an installation: `python -m simulators.srv1.prepare`."""

import numpy as np

from simulators.srv1.cameras import Overhead, RoverCamera, stage
from simulators.srv1.frame import Bin, Frame

if __name__ == "__main__":
    Frame(RoverCamera(stage()).take(np.eye(4))).blobs(Bin())
    Overhead(stage()).take(np.eye(4))
