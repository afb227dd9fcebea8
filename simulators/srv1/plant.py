"""The rover's body in the hall, with showcases that can be moved."""

import numpy as np

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import Hall, hall
from simulators.common.rovers.body import Body, Point, Pose
from simulators.srv1 import scene


class Plant(Body):
    """See `Body`."""

    HELD = 5.0

    def __init__(self, pose: Pose, where: Hall | None = None) -> None:
        self._hall = where or hall()
        super().__init__(scene.spec(self._hall), scene.WHEELS, float(load("srv1")["body"]["wheel_radius"]), pose)
        self._hull = self._model.geom("hull").id
        self._cases = {case.name: (int(self._model.body(case.name).mocapid[0]), case.at) for case in self._hall.cases}

    def move(self, case: str, dx: float, dy: float) -> None:
        """Move a showcase to this distance (m) from where the description has it. Raises KeyError: there is none."""
        number, (x, y) = self._cases[case]
        self._data.mocap_pos[number, :2] = x + dx, y + dy
        self._wake()

    def offset(self, case: str) -> tuple[float, float]:
        """Return how far a showcase is from where the description has it (m, m). Raises KeyError: there is none."""
        number, at = self._cases[case]
        x, y = self._data.mocap_pos[number, :2]
        return float(x) - at[0], float(y) - at[1]

    def _set_friction(self, share: float) -> None:
        self._model.pair_friction[:, 0], self._model.pair_friction[:, 1] = scene.ACROSS * share, scene.ALONG * share

    def block(self, blocked: bool) -> None:
        """Hold all wheels fast, or let them go."""
        super().block(blocked)
        self._model.actuator_forcerange[:] = np.array([-1.0, 1.0]) * scene.STALL_NM * (0.0 if blocked else 1.0)

    @property
    def contacts(self) -> tuple[str, ...]:
        """Return what the hull touches: names of showcases and exhibits, `wall0` to `wall3` (S, N, W, E)."""
        pairs = [(c.geom1, c.geom2) for c in self._data.contact if self._hull in (c.geom1, c.geom2)]
        return tuple(sorted({self._names[a + b - self._hull] for a, b in pairs}))

    def in_sight(self, origin: Point, place: Point) -> bool:
        """Return whether nothing stands between a point of the rover's frame and a place of the hall (m)."""
        begin = self.place(origin)
        way = np.subtract(place, begin)
        distance = float(np.linalg.norm(way))
        return not 0.0 <= self._ray(begin, way / max(distance, 1e-9)) < distance
