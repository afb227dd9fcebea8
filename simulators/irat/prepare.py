"""Compile the cameras' loops, once after an installation: `python -m simulators.irat.prepare`."""

import numpy as np

from simulators.irat.cameras import Overhead, RobotCamera, Stage

if __name__ == "__main__":
    stage = Stage()
    RobotCamera(stage).take(np.eye(4))
    Overhead(stage).take(np.eye(4))
