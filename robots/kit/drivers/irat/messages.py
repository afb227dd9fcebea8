"""Messages that the iRat publishes, as values with SI units and as ROS messages.

They are read from ROS 1 and ROS 2 as rosbridge_server writes them: it writes `null` for NaN and both infinities, and
floats of 32 bits may be a little above one where one is meant.
"""

import base64
import binascii
from dataclasses import dataclass
from math import atan2, cos, hypot, inf, sin

from robots.kit.description import load
from robots.kit.drivers.irat.protocol import CHARGING, DISCHARGING, FULL, NOT_CHARGING, Velocity, header, seconds_of
from robots.kit.drivers.rosbridge import Malformed, Message, is_number, nested, numeral

MOST_JPEG = 200_000  # bytes
FAR = 1e6
ROUNDED = 0.01  # by so much the length of a unit quaternion, or a share, may differ


def stamp_of(message: Message) -> float:
    """Return when a message was made (wall clock, s). Raises Malformed."""
    return seconds_of(nested(nested(message, "header"), "stamp"))


@dataclass(frozen=True)
class Odometry:
    """The pose since the robot was switched on, by its odometry (m, rad), and its velocity."""

    x: float
    y: float
    heading: float
    velocity: Velocity
    stamp: float = 0.0  # the robot's own clock (s)

    def encode(self, sequence: int, at: float) -> Message:
        """Return the nav_msgs/Odometry; `at` is the wall clock (s)."""
        turn = {"x": 0.0, "y": 0.0, "z": sin(self.heading / 2), "w": cos(self.heading / 2)}
        pose = {"position": {"x": self.x, "y": self.y, "z": 0.0}, "orientation": turn}
        return {
            "header": header(sequence, at, "odom"),
            "child_frame_id": "base_link",
            "pose": {"pose": pose, "covariance": [0.0] * 36},
            "twist": {"twist": self.velocity.encode(), "covariance": [0.0] * 36},
        }

    @classmethod
    def decode(cls, message: Message) -> "Odometry":
        """Return the odometry in a message. Raises Malformed."""
        pose, twist = (nested(nested(message, name), name) for name in ("pose", "twist"))
        place, turn = nested(pose, "position"), nested(pose, "orientation")
        z, w = numeral(turn, "z", -2, 2), numeral(turn, "w", -2, 2, default=1.0)
        if abs(hypot(z, w) - 1) > ROUNDED:
            raise Malformed("the orientation must be a quaternion of length 1 about the vertical axis")
        heading = 2 * atan2(z, w)
        velocity = Velocity(
            numeral(nested(twist, "linear"), "x", -FAR, FAR), numeral(nested(twist, "angular"), "z", -FAR, FAR)
        )
        x, y = (numeral(place, name, -FAR, FAR) for name in ("x", "y"))
        return cls(x, y, atan2(sin(heading), cos(heading)), velocity, stamp_of(message))


def velocities(velocity: Velocity, sequence: int, at: float) -> Message:
    """Return the wheels' velocity as a geometry_msgs/TwistStamped."""
    return {"header": header(sequence, at, "base_link"), "twist": velocity.encode()}


@dataclass(frozen=True)
class Ranges:
    """Distances (m) to the left, ahead and to the right; the farthest is also read where nothing is nearer."""

    left: float
    ahead: float
    right: float

    def encode(self, sequence: int, at: float) -> Message:
        """Return the sensor_msgs/LaserScan, whose angles run from right to left."""
        known = load("irat")["range"]
        return {
            "header": header(sequence, at, "ranges"),
            "angle_min": known["angles"][2], "angle_max": known["angles"][0], "angle_increment": known["angles"][0],
            "time_increment": 0.0, "scan_time": 0.05, "range_min": known["near"], "range_max": known["far"],
            "ranges": [round(self.right, 4), round(self.ahead, 4), round(self.left, 4)], "intensities": [],
        }  # fmt: skip

    @classmethod
    def decode(cls, message: Message) -> "Ranges":
        """Return the ranges in a message. Raises Malformed.

        By REP 117 a range without an object is infinite, or beyond `range_max`, and one that is too near is -infinite.
        """
        found, told = message.get("ranges"), message.get("range_max")
        if not isinstance(found, list) or len(found) != 3:
            raise Malformed("there must be three ranges")
        far = float(told) if is_number(told) and 0 < told <= FAR else float(load("irat")["range"]["far"])
        right, ahead, left = (_range(value, far) for value in found)
        return cls(left, ahead, right)


def _range(value: object, far: float) -> float:
    """Return a distance (m); rosbridge's null is most often an infinite one. Raises Malformed."""
    if value == -inf:
        return 0.0
    if value is None or (isinstance(value, int | float) and not isinstance(value, bool) and not value <= far):
        return far
    return numeral({"range": value}, "range", 0, far, "m")


@dataclass(frozen=True)
class BatteryState:
    """Volts at the terminals, amperes into the battery, the share that is left, and the recharge state."""

    voltage: float
    current: float
    share: float
    status: int

    def encode(self, sequence: int, at: float) -> Message:
        """Return the sensor_msgs/BatteryState."""
        known = load("irat")["battery"]
        return {
            "header": header(sequence, at, "battery"),
            "voltage": round(self.voltage, 3), "current": round(self.current, 3),
            "charge": round(self.share * known["capacity_ah"], 4), "capacity": known["capacity_ah"],
            "design_capacity": known["capacity_ah"], "percentage": round(self.share, 4),
            "power_supply_status": self.status, "power_supply_health": 1, "power_supply_technology": 2,
            "present": True, "cell_voltage": [], "location": "", "serial_number": "",
        }  # fmt: skip

    @classmethod
    def decode(cls, message: Message) -> "BatteryState":
        """Return the battery's state in a message. Raises Malformed.

        A quantity that is not measured is NaN there. A current that is not measured counts as 0 A; a share that is not
        measured is the charge divided by the capacity, or else follows from the voltage of an empty and a full battery.
        """
        voltage, status = numeral(message, "voltage", 0, 100, "V"), int(numeral(message, "power_supply_status", 0, 4))
        share = _measured(message, "percentage", -ROUNDED, 1 + ROUNDED)
        charge = _measured(message, "charge", -FAR, FAR, "Ah")
        if share is None and charge is not None:
            whole = (_measured(message, name, 0, FAR, "Ah") for name in ("capacity", "design_capacity"))
            share = next((charge / capacity for capacity in whole if capacity), None)
        if share is None:
            known = load("irat")["battery"]
            share = (voltage - known["empty"]) / (known["full"] - known["empty"])
        return cls(voltage, _measured(message, "current", -100, 100, "A") or 0.0, min(max(share, 0.0), 1.0), status)


def _measured(message: Message, name: str, low: float, high: float, unit: str = "") -> float | None:
    """Return a number of a battery, None where it is not measured. Raises Malformed."""
    value = message.get(name)
    return None if value is None or value != value else numeral(message, name, low, high, unit)


def current_of(message: Message) -> float:
    """Return the charger's current (A) in a std_msgs/Float32; noise below zero is none. Raises Malformed."""
    return max(numeral(message, "data", -100, 100, "A"), 0.0)


def recharge_state(charger_current: float, full: bool) -> int:
    """Return the power_supply_status: it is charging only if the charger gives a current (A)."""
    if full:
        return FULL
    if charger_current > 0.0:
        return CHARGING
    return DISCHARGING if charger_current == 0.0 else NOT_CHARGING


@dataclass(frozen=True)
class Picture:
    """A JPEG and when it was taken (wall clock, s)."""

    jpeg: bytes
    at: float

    def encode(self, sequence: int) -> Message:
        """Return the sensor_msgs/CompressedImage; rosbridge writes bytes in base 64."""
        return {
            "header": header(sequence, self.at, "camera"), "format": "jpeg",
            "data": base64.b64encode(self.jpeg).decode(),
        }  # fmt: skip

    @classmethod
    def decode(cls, message: Message) -> "Picture":
        """Return the picture in a message. Raises Malformed."""
        data = message.get("data")
        kind = str(message.get("format")).lower()
        if not isinstance(data, str) or len(data) > MOST_JPEG * 4 // 3 + 4 or not ("jpeg" in kind or "jpg" in kind):
            raise Malformed(f"a picture is a JPEG of at most {MOST_JPEG} bytes in base 64")
        try:
            jpeg = base64.b64decode(data, validate=True)
        except (binascii.Error, ValueError) as error:
            raise Malformed("the picture is not base 64") from error
        if not jpeg.startswith(b"\xff\xd8"):
            raise Malformed("the picture is not a JPEG")
        return cls(jpeg, stamp_of(message))
