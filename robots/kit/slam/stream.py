"""The changes of the map since a reader's last question, so that only these are sent."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.kit.slam.experiences import ExperienceMap

STEPS = 1000  # a pose counts as changed when its value in mm or mrad does


@dataclass(frozen=True)
class Changes:
    """The difference to an earlier sequence number, or with `whole` everything there is.

    ids: (n,); poses: (n, 3) of x, y (m), facing (rad), in whole mm and mrad; links: (m, 2) of ids.
    """

    map_number: int
    sequence: int
    whole: bool
    ids: NDArray[np.int64]
    poses: NDArray[np.float64]
    links: NDArray[np.int64]


class ChangeLog:
    """When each experience and link last changed, in sequence numbers."""

    def __init__(self, sequence: int) -> None:
        self.whole_since = sequence
        self.poses: NDArray[np.int64] = np.zeros((0, 3), np.int64)
        self.nodes_at: NDArray[np.int64] = np.zeros(0, np.int64)
        self.links_at: NDArray[np.int64] = np.zeros(0, np.int64)

    def note(self, graph: ExperienceMap, sequence: int) -> None:
        """Compare the map with what it was at the last call."""
        poses = np.rint(graph.poses[: graph.count] * STEPS).astype(np.int64)
        fresh = np.ones(len(poses), bool)
        before = len(self.poses)
        fresh[:before] = (poses[:before] != self.poses).any(axis=1)
        self.nodes_at = np.where(fresh, sequence, np.resize(self.nodes_at, len(poses)) if before else 0)
        self.links_at = np.concatenate([self.links_at, np.full(graph.linked - len(self.links_at), sequence)])
        self.poses = poses

    def since(self, graph: ExperienceMap, map_number: int, sequence: int, last: int) -> Changes:
        """Return what changed after the sequence number `last`; everything if that is from before the last cut."""
        whole = not self.whole_since <= last <= sequence
        nodes = np.flatnonzero((self.nodes_at > last) | whole)
        links = np.flatnonzero((self.links_at > last) | whole)
        ends = np.column_stack([graph.ids[graph.sources[links]], graph.ids[graph.targets[links]]])
        return Changes(map_number, sequence, whole, graph.ids[nodes], self.poses[nodes] / STEPS, ends)


def activity(cells: NDArray[np.float64], faintest: float = 1 / 64) -> tuple[NDArray[np.uint16], NDArray[np.uint8]]:
    """Return the numbers of the active cells, ascending, and their activity, 255 the strongest, of (heading, y, x).

    A number is (heading * across + y) * across + x. Cells below the share `faintest` of the strongest are left out.
    """
    flat = cells.reshape(-1)
    share = flat / max(float(flat.max()), 1e-300)
    active = np.flatnonzero(share >= faintest)
    return active.astype(np.uint16), np.rint(share[active] * 255).astype(np.uint8)
