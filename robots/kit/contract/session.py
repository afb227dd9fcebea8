"""The session of a robot's driver: one robot behind one wire. All units are SI."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Any

from robots.kit.clock import TIMER, Timer
from robots.kit.contract.errors import CameraFault
from robots.kit.contract.joint_path import JointPath

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

JSON = dict[str, Any]
Permit = Callable[[], None]
Trace = Callable[[str, bytes, str], None]


@dataclass(frozen=True)
class Progress:
    """The progress of a long command: a few words, and the share that is done (0 to 1) where it is known."""

    text: str
    share: float | None = None


@dataclass(frozen=True)
class Observation:
    """A result of a long command on its way: words, and values by name in the units of the spec's channels.

    With `photograph` a picture of the first camera is taken now and stored with them; `on_stage` waits for it.
    """

    text: str
    values: Mapping[str, float] = field(default_factory=dict)
    photograph: bool = False


@dataclass(frozen=True)
class Moves:
    """The path on which the robot moves by itself from now on: viewers draw it before the states come.

    `at` is when it began, on the session's `clock` (s).
    """

    path: JointPath
    at: float


Noted = Observation  # its name in 0.1, until 1.0
Report = str | Progress | Observation | Moves  # all that a driver reports of a command that runs
OnStage = Callable[[Report], None]
OnPacket = Callable[[str, bytes, bool], bool]


@dataclass(frozen=True)
class RobotState:
    """A state as the hardware told it. Joints in rad and m; pose (x, y, z, angles...) in m and rad, or empty.

    A robot that knows them adds each joint's velocity (rad/s, m/s), the torque applied (N m, N)
    and its controller's own word for what it is doing. `twist` is the body's velocity along and about its own axes, one
    number for each coordinate of the pose (m/s, rad/s): of a pose in the plane forward, to the left, turning left.
    `values` are those of the channels that the spec declares, by name. `at` is when the hardware was heard, on the
    session's `clock` (s), which is `time.monotonic` unless it was given another; it is converted in one place, the
    owner's `OwnedRobot.age`.
    """

    at: float
    joints: tuple[float, ...]
    pose: tuple[float, ...]
    moving: bool
    ready: bool
    fault: str = ""
    velocities: tuple[float, ...] = ()
    torques: tuple[float, ...] = ()
    mode: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    twist: tuple[float, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """The values that were really sent, and the state of the robot now."""

    sent: JSON = field(default_factory=dict)
    state: RobotState | None = None


class Session(ABC):
    """The base of every driver. The constructor opens nothing; five methods are a robot's own.

    `address` is a port, a file or a URL. `settings` may hold the owner's fencing `epoch`, a secret `token`, `folder`,
    where a driver may store files between its runs, and those settings of the robot's spec that staff have set. `trace`
    is called with each message on the wire: direction, bytes, words.
    """

    clock: Timer = TIMER  # for limits and states; tests may let time pass faster
    _latest: RobotState | None = None
    on_packet: OnPacket | None = None  # this one and the next three are the owner's, where there is one
    on_time_left: Callable[[], float] | None = None
    on_steered: Callable[[], JSON] | None = None
    on_look: "Callable[..., NDArray[np.uint8]] | None" = None

    def __init__(self, address: str, settings: JSON, trace: Trace | None = None) -> None:
        self.address, self.settings, self.trace = address, settings, trace

    @abstractmethod
    def connect(self) -> RobotState:
        """Open the wire and ask the hardware for its state. Raises HardwareFault.

        After LineSilent it is called again without a `close`: a controller that boots whenever its port is opened must
        not be opened again while it boots. After every other fault the wire was closed.
        """

    @abstractmethod
    def state(self) -> RobotState:
        """Ask the hardware. Raises HardwareFault."""

    @abstractmethod
    def execute(self, kind: str, args: JSON, permit: Permit, on_stage: OnStage) -> Outcome:
        """Carry out a command and wait for its end; `permit` is called right before every actuation.

        `on_stage` is called with "sent", then with "acknowledged" once the robot has understood; then the deadline to
        begin is met. `on_stage` may take as long as a database takes, so no lock that `hold` needs may be held
        meanwhile; `permit` reads memory only until then. A long command passes a `Progress` after that, as often as it
        likes: some are left out if they come too often. A robot that has accepted a motion of joints, and knows how it
        will go, passes `Moves` once after that; one that does not know passes none.

        Where a command is replaceable, `permit` is called on its way too, and raises MotionReplaced
        when the robot is to be left in motion for the target that comes next. A hold that
        another thread asks for meanwhile ends it for good with MotionHeld, whatever `permit` says.

        Raises whatever `permit` raises, MotionHeld, BadRequest, OutOfWorkspace, HardwareFault.
        """

    @abstractmethod
    def hold(self) -> RobotState:
        """Bring the robot to rest now; any thread may call it. Raises HardwareFault where that is not certain."""

    @abstractmethod
    def close(self) -> None:
        """Release the wire. Never raises."""

    def recover(self, permit: Permit) -> RobotState:
        """Reset after a fault and return to the previous position; a robot without a reset is connected anew."""
        permit()
        self.close()
        return self.connect()

    def time_left(self) -> float:
        """Return for how long (s) the running command may still move, as far as its owner knows now; `inf`: no limit.

        That is until its grant ends, or sooner where the live link is lost. A driver whose robot goes on without
        repeated messages (a permit, a trajectory) lets that end sooner, by the time that braking takes.
        """
        return inf if self.on_time_left is None else self.on_time_left()

    def steered(self, args: JSON) -> JSON:
        """Return the newest values of the held command that runs, which began with `args`: those of its controls now.

        For kinds with `steered`. The values are checked as those of the command. Call it again and again: it reads
        memory only.
        """
        return {**args, **(self.on_steered() if self.on_steered is not None else {})}

    def look(self, view: str, colour: bool = False) -> "NDArray[np.uint8]":
        """Return a picture of the robot's camera of that name, taken from now on.

        It is grey (height, width), or with `colour` blue, green, red (height, width, 3).
        It is as viewers see it: black where a privacy mask is. It may take two seconds. Raises CameraFault.
        """
        if self.on_look is None:
            raise CameraFault("The robot has no camera.")
        return self.on_look(view, True) if colour else self.on_look(view)

    def rests_within(self) -> float | None:
        """Return within how many seconds the robot rests if no message reaches it from now on; None: see `Spec.rest_s`.

        For a robot that may go on by itself for a time. It reads memory only; any thread may call it.
        """
        return None

    def picture(self, view: str, seconds: float) -> bytes | None:
        """Return the first JPEG or PNG of a camera that was taken from now on, None if none is in so many seconds.

        Only for cameras whose pictures come over the robot's own wire: `[camera] by_driver = true`. Any thread.
        """
        return None

    def latest(self) -> RobotState | None:
        """Return the newest state that was kept, without asking the hardware."""
        return self._latest

    def keep(self, state: RobotState) -> RobotState:
        """Store the newest state and return it; a driver calls this with each state that it receives."""
        self._latest = state
        return state

    def stream(self, name: str, data: bytes, key: bool = True) -> bool:
        """Send the next packet of a byte stream that the spec declares; any thread may call it, and it never waits.

        A key packet holds everything, a delta (`key` false) what changed since the packet before; driver and console
        agree on the meaning of both. Returns True if the next one has to be a key packet: nobody takes deltas yet, or
        enough of them follow the last key packet.

        Raises ValueError where no such stream is declared or the packet is over 1 MiB.
        """
        return self.on_packet is None or self.on_packet(name, data, key)
