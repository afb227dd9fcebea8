"""The scene of a composite (see `capabilities.Composite`): takes streams, a picture and a state, returns pixels."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robots.kit.contract.session import RobotState

Pixels = NDArray[np.uint8]


class Scene(Protocol):
    """One composite of one robot. Not for several threads; none of its methods may take long."""

    def take(self, stream: str, data: bytes, key: bool) -> None:
        """Take the next packet of a byte stream. Raises ValueError for one that cannot be read."""

    def draw(self, picture: bytes | None, state: RobotState | None, jobs: Sequence[Mapping[str, Any]]) -> Pixels:
        """Return height x width x 3, blue-green-red.

        `picture`: the newest of the first camera, a JPEG. `state`: `values` hold channels and coordinates of the pose
        by name. `jobs`: the arguments of open jobs in the order of their turns, the one under way first.
        """
