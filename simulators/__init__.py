"""Simulated robots: each is a process that speaks its robot's wire.

MuJoCo reads `MUJOCO_GL` and OpenBLAS its number of threads when they are imported, so both are set here.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # more threads would only wait for each other
os.environ.setdefault("MUJOCO_GL", "disable")  # physics needs no window system
