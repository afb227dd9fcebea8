"""The hall rover, in MuJoCo, which needs no graphics library here."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUJOCO_GL", "disable")  # physics needs no window system; the pictures are our own
