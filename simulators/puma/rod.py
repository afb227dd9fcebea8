"""The rod on two threads from the ceiling, and the wind that makes it swing.

A thread is a tendon with a longest length and no shortest: it is slack when the rod is lifted.
"""

import mujoco
import numpy as np

from simulators.puma.cell import Floats, Thing

ROD, THREADS_X, CEILING_M = "rod", (0.42, 0.68), 2.0
KG = 0.10
STILL_S = 11.0  # in which a swing decays to 1/e of its width, in still air
TURN_S = 3.0  # and a turn about its own middle
DRAG = 0.5 * 1.2 * 1.1  # of a cylinder across the wind: N per m2 and (m/s)2
FRICTION = (0.7, 0.005, 0.0001)
STIFF = (0.01, 1.0)  # of a taut thread: time (s) and damping ratio
THREADS = ("near thread", "far thread")


def add(made: mujoco.MjSpec, thing: Thing, masks: int) -> None:
    """Add rod and threads; `masks` are the bits of the studs against which it collides."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, thing.first[:3, :3].ravel())
    middle = thing.first[:3, 3]
    body = made.worldbody.add_body(name=ROD, pos=middle, quat=quaternion)
    body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER  # at the end of each swing it stands still
    body.add_freejoint(name=f"{ROD}_free")
    radius, half = thing.size[0] / 2, thing.size[2] / 2
    body.add_geom(name=ROD, type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[radius, half, 0], mass=KG, friction=FRICTION,
                  contype=1, conaffinity=1 | masks, condim=4, solref=[0.006, 1.0],
                  solimp=[0.99, 0.999, 0.001, 0.5, 2.0])  # fmt: skip
    for name, x in zip(THREADS, THREADS_X, strict=True):
        knot = thing.first[:3, :3].T @ (np.array([x, middle[1], middle[2] + radius]) - middle)
        body.add_site(name=f"{name} below", pos=knot, size=[0.001, 0.001, 0.001])
        made.worldbody.add_site(name=f"{name} above", pos=[x, middle[1], CEILING_M], size=[0.001, 0.001, 0.001])
        thread = made.add_tendon(name=name, limited=True, range=[0.0, CEILING_M - middle[2] - radius])
        thread.solref_limit = STIFF
        thread.wrap_site(f"{name} above")
        thread.wrap_site(f"{name} below")


def damp(model: mujoco.MjModel) -> None:
    """Set the resistance of still air to the rod."""
    body = model.body(ROD)
    first = int(model.joint(f"{ROD}_free").dofadr[0])
    model.dof_damping[first : first + 3] = 2 * KG / STILL_S
    model.dof_damping[first + 3 : first + 6] = 2 * body.inertia / TURN_S


def wind(velocity: Floats, speed: float, thing: Thing) -> Floats:
    """Return the force (N) of a wind along y (m/s) on a rod that moves with `velocity` (m/s)."""
    past = speed - float(velocity[1])
    return np.array([0.0, DRAG * thing.size[0] * thing.size[2] * past * abs(past), 0.0])
