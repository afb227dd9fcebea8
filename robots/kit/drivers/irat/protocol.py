"""The iRat's topics and services, for driver and simulator alike: ROS messages by rosbridge v2.

`irat_serial` and `irat_camera` are the paper's nodes (section 3.2): velocities in; velocities, battery and recharge
state out; JPEG pictures of 416 x 240 at 20 Hz. Odometry, ranges, hold, claim and status are ours.
"""

from dataclasses import dataclass
from typing import Any

from robots.kit.description import load
from robots.kit.drivers.rosbridge import Malformed, Message, nested, numeral

COMMAND, DRIVE = "/irat/cmd_vel", "/irat/drive"  # the second has the epoch, and the stamp of the odometry before it
VELOCITIES, ODOMETRY, RANGES = "/irat/velocities", "/irat/odom", "/irat/ranges"
BATTERY, CHARGER, STATE = "/irat/battery", "/irat/charger_current", "/irat/state"
CAMERA = "/irat/camera/image/compressed"
TOPICS = {
    COMMAND: "geometry_msgs/Twist",
    DRIVE: "irat/Drive",
    VELOCITIES: "geometry_msgs/TwistStamped",
    ODOMETRY: "nav_msgs/Odometry",
    RANGES: "sensor_msgs/LaserScan",
    BATTERY: "sensor_msgs/BatteryState",
    CHARGER: "std_msgs/Float32",
    STATE: "irat/State",
    CAMERA: "sensor_msgs/CompressedImage",
}
EVERY_S = {VELOCITIES: 0.05, ODOMETRY: 0.05, RANGES: 0.05, BATTERY: 1.0, CHARGER: 0.2, STATE: 0.1, CAMERA: 0.05}
HOLD, CLAIM, STATUS = "/irat/hold", "/irat/claim", "/irat/status"
SERVICES = {HOLD: "std_srvs/Trigger", CLAIM: "irat/Claim", STATUS: "irat/Status"}
LARGEST_EPOCH = 2**53 - 1
REST_S = 2.0  # the longest that a hold may take
LATE_S = 0.5  # a velocity that answers to older odometry is refused
CHARGING, DISCHARGING, NOT_CHARGING, FULL = 1, 2, 3, 4  # power_supply_status of a BatteryState


@dataclass(frozen=True)
class Velocity:
    """Forward speed (m/s) and rate of turn to the left (rad/s)."""

    linear: float
    angular: float

    def encode(self) -> Message:
        """Return a `geometry_msgs/Twist`: m/s forward, rad/s to the left."""
        zero = {"x": 0.0, "y": 0.0, "z": 0.0}
        return {"linear": {**zero, "x": self.linear}, "angular": {**zero, "z": self.angular}}

    @classmethod
    def decode(cls, twist: Message) -> "Velocity":
        """Return the velocity in a Twist that the robot can follow. Raises Malformed, OutOfBounds."""
        motion = load("irat")["motion"]
        linear, angular = nested(twist, "linear"), nested(twist, "angular")
        for part, names in ((linear, "yz"), (angular, "xy")):
            for name in names:
                numeral(part, name, 0, 0, "on a robot with two wheels")
        return cls(
            numeral(linear, "x", -motion["speed"], motion["speed"], "m/s"),
            numeral(angular, "z", -motion["turn"], motion["turn"], "rad/s"),
        )


@dataclass(frozen=True)
class Drive:
    """A velocity, under whose epoch it is, and the stamp (s) of the odometry that it answers to."""

    velocity: Velocity
    epoch: int
    stamp: float

    def encode(self) -> Message:
        """Return the `irat/Drive`. It has no header, whose fields differ in ROS 1 and 2, and which rosbridge fills."""
        sec, nanosec = divided(self.stamp)
        return {"epoch": self.epoch, "sec": sec, "nanosec": nanosec, "twist": self.velocity.encode()}

    @classmethod
    def decode(cls, message: Message) -> "Drive":
        """Return the velocity in a message. Raises Malformed, OutOfBounds."""
        return cls(Velocity.decode(nested(message, "twist")), epoch_of(message), seconds_of(message))


@dataclass(frozen=True)
class Status:
    """The state that the robot tells: the values of topic `STATE` and of service `STATUS`.

    `boot` counts its starts, `motion` its motions since; `end` is how the newest motion ended: none, done, silence,
    held, lost, replaced. `epoch` is the commander's, 0 while there is none.
    """

    boot: int
    motion: int
    end: str
    moving: bool
    holding: bool
    stalled: bool
    charging: bool
    epoch: int
    seconds: float  # since it was switched on

    def encode(self) -> Message:
        """Return the fields under their names, as rosbridge sends them."""
        return dict(self.__dict__)

    @classmethod
    def decode(cls, message: Message) -> "Status":
        """Return the status in a message. Raises Malformed."""
        boot, motion, epoch = (int(numeral(message, name, 0, LARGEST_EPOCH)) for name in ("boot", "motion", "epoch"))
        moving, holding, stalled, charging = (
            message.get(name) is True for name in ("moving", "holding", "stalled", "charging")
        )
        end, seconds = str(message.get("end", "none"))[:20], numeral(message, "seconds", 0, 1e12)
        return cls(boot, motion, end, moving, holding, stalled, charging, epoch, seconds)


def epoch_of(args: Message) -> int:
    """Return the epoch in the arguments of a claim, or in a Drive. Raises Malformed, OutOfBounds."""
    epoch = numeral(args, "epoch", 1, LARGEST_EPOCH)
    if epoch != int(epoch):
        raise Malformed("epoch must be a whole number")
    return int(epoch)


def seconds_of(stamp: Message) -> float:
    """Return the seconds of a stamp, by the names of ROS 1 or ROS 2; 0 without any. Raises Malformed."""
    whole, rest = ("sec", "nanosec") if "sec" in stamp else ("secs", "nsecs")
    return numeral(stamp, whole, 0, 1e12) + numeral(stamp, rest, 0, 1e9) * 1e-9


def header(sequence: int, at: float, frame: str) -> dict[str, Any]:
    """Return a std_msgs/Header; `at` is the wall clock in s."""
    secs, nsecs = divided(at)
    return {"seq": sequence, "stamp": {"secs": secs, "nsecs": nsecs}, "frame_id": frame}


def divided(at: float) -> tuple[int, int]:
    """Return whole seconds and nanoseconds of a time (s)."""
    return int(at), int((at - int(at)) * 1e9)
