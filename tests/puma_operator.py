"""Drives the plant of the PUMA 560 along planned paths, as its controller does, for tests of the cell's physics."""

from functools import cache

import mujoco
import numpy as np

from robots.kit.arms.described import planner, posture
from robots.kit.arms.pose import matrix
from robots.kit.description import load
from simulators.common.arm.controllers import ComputedTorque
from simulators.puma.plant import Plant

STEP_S = 0.002
plan = cache(planner)


def down(x, y, z, yaw=0.0):
    """Return the pose (4 x 4) of a tool that points down, its fingers beside each other along y turned by `yaw`."""
    return matrix((x, y, z, np.pi, 0.0, np.pi + yaw))


class Operator:
    """The plant with a controller: `go` moves, `grip` and `release` close and open the fingers, `wait` lets time pass."""

    def __init__(self, plant=None):
        self.ready = posture(load("puma"), "ready")
        self.plant = plant or Plant(self.ready)
        self._controller = ComputedTorque("puma")
        self._planner = plan("puma")
        self.q, self.closed = self.plant.measured().q, 0
        self.seen = []  # is called after each step

    def step(self, q, v, a):
        self.plant.step(self._controller.torques(q, v, a, self.plant.measured()), self.closed)
        self.q = q
        for look in self.seen:
            look()

    def wait(self, seconds):
        still = np.zeros(6)
        for _ in range(round(seconds / STEP_S)):
            self.step(self.q, still, still)

    def follow(self, path):
        for k in range(round(path.seconds / STEP_S) + 1):
            self.step(*path.at(k * STEP_S))

    def joints(self, q, scale=1.0):
        self.follow(self._planner.joints(q, self.q, np.zeros(6), scale).path)

    def go(self, pose, scale=1.0):
        """Move by a joint motion, planned among the boxes."""
        self.joints(self._planner.reach(pose, self.q), scale)

    def line(self, pose, scale=0.3):
        """Move the tool on a straight line."""
        self.follow(self._planner.line(pose, self.q, np.zeros(6), scale).path)

    def grip(self):
        self.closed = 1
        self.wait(0.7)

    def release(self):
        self.closed = 0
        self.wait(0.5)

    def take(self, x, y, z, yaw=0.0, high=0.10):
        """Grasp at a place from above and lift."""
        self.go(down(x, y, z + high, yaw))
        self.line(down(x, y, z, yaw))
        self.grip()
        self.line(down(x, y, z + high, yaw))

    def put(self, name, x, y, z, yaw=0.0):
        """Put an object at a place as if by hand; it may overlap with others."""
        joint = self.plant.model.joint(f"{name}_free")
        at, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
        self.plant.data.qpos[at : at + 7] = [x, y, z, np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]
        self.plant.data.qvel[dof : dof + 6] = 0.0
        mujoco.mj_forward(self.plant.model, self.plant.data)

    def pull(self, name, force, seconds):
        """Apply a force (N, three numbers) to the middle of an object; return the greatest kinetic energy (J) of it."""
        body, most = self.plant.model.body(name), 0.0
        for _ in range(round(seconds / STEP_S)):
            self.plant.data.xfrc_applied[body.id, :3] = force
            self.wait(STEP_S)
            most = max(most, self.energy(name))
        self.plant.data.xfrc_applied[body.id, :3] = 0.0
        return most

    def energy(self, name):
        """Return the kinetic energy (J) of an object."""
        body, v = self.plant.model.body(name), np.zeros(6)
        mujoco.mj_objectVelocity(self.plant.model, self.plant.data, mujoco.mjtObj.mjOBJ_BODY, body.id, v, 1)
        return 0.5 * float(body.mass[0] * v[3:] @ v[3:] + v[:3] @ (body.inertia * v[:3]))

    def press(self, x, y, z, yaw=0.0, high=0.10):
        """Press what is held onto something, and leave it there."""
        self.go(down(x, y, z + high, yaw))
        self.line(down(x, y, z, yaw))
        self.wait(0.4)
        self.release()
        self.line(down(x, y, z + high, yaw))
