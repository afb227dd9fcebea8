"""The round of a patrol: from node to node of the map, each time to the one whose last visit is oldest. Pure; m."""

from math import dist, hypot

from robots.kit.contract.errors import OutOfWorkspace
from robots.kit.drivers.srv1.following import TURN_FIRST_RAD, Pose, bearing, is_reached
from robots.kit.drivers.srv1.hall import Hall, Node, hall
from robots.kit.drivers.srv1.ways import Place, length, way

ASTRAY_M = 0.5  # farther from its line than this it was driven elsewhere, or its place was estimated anew


class Round:
    """Leads one rover. It begins at the nearest node, and turns back where something stands in the way."""

    def __init__(self, floor: Hall | None = None) -> None:
        self._floor = hall() if floor is None else floor
        self._nodes = {node.name: node for node in self._floor.nodes}
        self._visits = dict.fromkeys(self._nodes, 0)
        self._count = 0
        self.restart()

    def restart(self) -> None:
        """Begin at the nearest node: the rover is elsewhere now."""
        self._line: list[Place] = []  # from where it is led, and the corners that are left
        self._to: Node | None = None

    @property
    def goal(self) -> str:
        """Return the name of the node to which it is led; empty if there is none."""
        return self._to.name if self._to else ""

    def aside(self, pose: Pose, near: bool) -> float:
        """Return the direction of the way, to the left of its heading (rad); 0 where there is no way.

        `near`: whether something stands before the rover.
        """
        if len(self._line) > 1 and _away(pose, self._line) > ASTRAY_M:
            self.restart()
        if self._to is None:
            self._begin(pose)
        while len(self._line) > 1 and is_reached(pose, self._line[0], self._line[1], passed=True):
            self._line.pop(0)
            if len(self._line) == 1:
                self._choose()
        aside = self._bearing(pose)
        if not near or abs(aside) > TURN_FIRST_RAD or len(self._line) < 2:
            return aside
        self._turn_back(pose)  # a thing stands in the way
        return self._bearing(pose)

    def _bearing(self, pose: Pose) -> float:
        return bearing(pose, *self._line[:2]) if len(self._line) > 1 else 0.0

    def _begin(self, pose: Pose) -> None:
        here, found = pose[:2], []
        for node in self._nodes.values():
            try:
                corners = way(here, node.at, self._floor)
            except OutOfWorkspace:
                continue
            found.append((length(here, corners), node.name, corners))
        if found:
            _, name, corners = min(found)
            self._line, self._to = [here, *corners], self._nodes[name]

    def _choose(self) -> None:
        """Lead on from the node that is reached."""
        self._to = min(self._neighbours(), key=lambda node: self._visits[node.name])
        self._line.append(self._to.at)

    def _neighbours(self) -> list[Node]:
        """Note that the node to which it was led is visited; return the nodes to which a way leads from there."""
        assert self._to is not None
        self._count += 1
        self._visits[self._to.name] = self._count
        return [self._nodes[name] for name in self._to.to]

    def _turn_back(self, pose: Pose) -> None:
        """Lead to another node than the one behind what stands in the way, which counts as visited."""
        back = min(self._neighbours(), key=lambda node: dist(node.at, pose[:2]))
        try:
            self._line, self._to = [pose[:2], *way(pose[:2], back.at, self._floor)], back
        except OutOfWorkspace:
            self.restart()


def _away(pose: Pose, line: list[Place]) -> float:
    """Return how far a pose is from the line that is driven (m)."""
    (ax, ay), (bx, by) = line[:2]
    dx, dy = bx - ax, by - ay
    long = dx * dx + dy * dy
    share = max(0.0, min(((pose[0] - ax) * dx + (pose[1] - ay) * dy) / long, 1.0)) if long else 0.0
    return hypot(pose[0] - ax - share * dx, pose[1] - ay - share * dy)
