"""The path of an accepted joint motion in at most 48 bytes, for viewers on slow lines: they draw it before it is told.

A packet is one big-endian number: 6, the mark of the compact layout, the low 32 bits of the command's number, the low
24 bits of the time in ms at which the motion began, its duration in ms (20 bits), the joints less one (4), the knots
less two (2), whether a velocity follows (1); then each knot's joints, then the velocity. All of these have as many bits
as 48 bytes leave, 8 to 16: a position in steps of its joint's scale from `low` to `high`, a velocity in steps from
minus to plus two such scales a second. `docs/reference/channels.md` has the table; `tests/vectors/path_packets.json`
holds packets that Python and TypeScript read alike.
"""

from dataclasses import dataclass

from robots.kit.contract.bits import BitReader
from robots.kit.contract.channels import Scale
from robots.kit.contract.compact import Layout
from robots.kit.contract.joint_path import MOST_JOINTS, JointPath

TYPE = 6
LONGEST = 48  # bytes
FEWEST_BITS, MOST_BITS = 8, 16  # of a position
HEAD_BITS = 8 + 8 + 32 + 24 + 20 + 4 + 2 + 1
COMMANDS, CLOCK, DURATIONS = 1 << 32, 1 << 24, 1 << 20  # of the command's number; ms; ms
FASTEST = 2.0  # scales a second


@dataclass(frozen=True)
class BegunPath:
    """A path, the low 32 bits of the number of its command, and when it began (ms since 1970)."""

    command: int
    began_ms: int
    path: JointPath

    @property
    def ends_ms(self) -> int:
        """Return when the motion ends (ms since 1970)."""
        return self.began_ms + round(self.path.seconds * 1000)


def command_of(data: bytes) -> int:
    """Return the low 32 bits of the number of a packet's command. Raises ValueError."""
    return _head(data) >> 51 & COMMANDS - 1


def seconds_of(data: bytes) -> float:
    """Return how long the motion in a packet lasts (s). Raises ValueError."""
    return (_head(data) >> 7 & DURATIONS - 1) / 1000


def _head(data: bytes) -> int:
    if not HEAD_BITS < 8 * len(data) <= 8 * LONGEST or data[0] != TYPE:
        raise ValueError("not a path")
    return int.from_bytes(data, "big") >> 8 * len(data) - HEAD_BITS


def bits_of(rows: int, joints: int) -> int:
    """Return the bits of a number in a packet of so many rows of joints."""
    return min(MOST_BITS, (8 * LONGEST - HEAD_BITS) // (rows * joints))


def encode_path(layout: Layout, begun: BegunPath) -> bytes | None:
    """Return the packet; None where a number is outside its scale, or the path is too long or of too many joints."""
    path, ms = begun.path, round(begun.path.seconds * 1000)
    joints, rows = len(path.knots[0]), len(path.knots) + bool(path.velocity)
    bits = bits_of(rows, joints)
    if joints > len(layout.joints) or bits < FEWEST_BITS or not 1 <= ms < DURATIONS:
        return None
    number = TYPE << 8 | layout.mark
    number = number << 32 | begun.command % COMMANDS
    number = number << 24 | begun.began_ms % CLOCK
    number = number << 20 | ms
    number = (number << 4 | joints - 1) << 3 | (len(path.knots) - 2) << 1 | bool(path.velocity)
    scales = layout.joints[:joints]
    codes = [_code(scale, value, bits) for row in path.knots for scale, value in zip(scales, row, strict=True)]
    codes += [_speed_code(scale, v, bits) for scale, v in zip(scales, path.velocity, strict=bool(path.velocity))]
    for code in codes:
        if code is None:
            return None
        number = number << bits | code
    size = -(-(HEAD_BITS + len(codes) * bits) // 8)
    return (number << 8 * size - HEAD_BITS - len(codes) * bits).to_bytes(size, "big")


def _code(scale: Scale, value: float, bits: int) -> int | None:
    most = (1 << bits) - 1
    code = round((value - scale.low) / _span(scale) * most)
    return code if 0 <= code <= most else None


def _speed_code(scale: Scale, velocity: float, bits: int) -> int | None:
    half = (1 << bits - 1) - 1
    code = round(velocity / (FASTEST * _span(scale)) * half) + half
    return code if 0 <= code <= 2 * half else None


def _span(scale: Scale) -> float:
    return scale.steps * scale.step


def decode_path(layout: Layout, data: bytes, near_ms: int) -> BegunPath:
    """Return the path in a packet; `near_ms`: a time at most two hours from its beginning.

    Raises ValueError for anything else than a path of this layout.
    """
    _head(data)
    if data[1] != layout.mark:
        raise ValueError("not a path of this layout")
    reader = BitReader(data, 16)
    take = reader.take
    command, stamp, ms, joints, knots, moving = take(32), take(24), take(20), take(4) + 1, take(2) + 2, take(1)
    bits, rows = bits_of(knots + moving, joints), knots + moving
    if joints > min(MOST_JOINTS, len(layout.joints)) or bits < FEWEST_BITS or reader.left // (rows * joints) < bits:
        raise ValueError("not a path of this layout")
    scales, most, half = layout.joints[:joints], (1 << bits) - 1, (1 << bits - 1) - 1
    found = tuple(tuple(s.low + take(bits) / most * _span(s) for s in scales) for _ in range(knots))
    velocity = tuple((take(bits) - half) / half * FASTEST * _span(s) for s in scales) if moving else ()
    behind = (near_ms - stamp + CLOCK // 2) % CLOCK - CLOCK // 2
    return BegunPath(command, near_ms - behind, JointPath(found, ms / 1000, velocity))
