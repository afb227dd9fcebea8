"""The museum arm in MuJoCo.

MuJoCo loads the graphics library that `MUJOCO_GL` names when it is imported, and the import fails if that library is
missing. So this is tried here first.
"""

import logging
import os

try:
    import mujoco
except Exception as error:  # noqa: BLE001 - whatever a graphics library raises
    logging.getLogger(__name__).warning("no graphics library for MUJOCO_GL=%s: %s", os.environ["MUJOCO_GL"], error)
    os.environ["MUJOCO_GL"] = "disable"
    import mujoco  # noqa: F401
