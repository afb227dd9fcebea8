"""What the simulated arms in MuJoCo share: plant, control layers, set-point, planning, cameras.

When MuJoCo is imported it loads the graphics library that `MUJOCO_GL` names, and the import fails if that library is
missing. So the import is tried here, and repeated without graphics.
"""

import logging
import os

try:
    import mujoco
except Exception as error:  # noqa: BLE001 - whatever a graphics library raises
    logging.getLogger(__name__).warning("no graphics library for MUJOCO_GL=%s: %s", os.environ["MUJOCO_GL"], error)
    os.environ["MUJOCO_GL"] = "disable"
    import mujoco  # noqa: F401
