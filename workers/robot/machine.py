"""The parts of the machine that an owner uses; a test gives it others."""

from collections.abc import Callable
from dataclasses import dataclass, field

from robots.kit.contract.find import open_session
from robots.kit.contract.session import JSON, Session, Trace
from workers.authority.processes import Processes
from workers.media.source import OpenCamera, open_camera

OpenSession = Callable[[str, str, JSON, Trace | None], Session]


@dataclass(frozen=True)
class Machine:
    """Opens a robot's session and its cameras, and knows the processes that may own robots."""

    session: OpenSession = open_session
    camera: OpenCamera = open_camera
    processes: Processes = field(default_factory=Processes)
