"""A robot's state in few bytes, for slow lines: each number as whole steps of its scale, bit by bit.

The spec declares the scales; the page that reads a packet and the worker that writes it both have the spec. A packet is
one big-endian number: 1, seven bits that depend on the layout, the low 16 bits of the time in ms, moving, stopped, the
number of the controller's word, then each joint and each packed value. A word that the spec does not name follows as
text. `docs/reference/channels.md` has the table; `tests/vectors/compact_states.json` holds packets that Python and
TypeScript read alike.
"""

import zlib
from dataclasses import dataclass
from functools import cached_property
from math import isfinite, nan
from typing import Any

from robots.kit.contract.bits import BitReader
from robots.kit.contract.channels import Scale
from robots.kit.contract.session import RobotState
from robots.kit.contract.spec import Spec

FIRST = 128  # the first byte of a compact state is not below
CLOCK = 1 << 16  # ms after which the stamp begins again
HEAD_BITS = 8 + 16 + 2


@dataclass(frozen=True)
class Layout:
    """The content of a compact state: a scale for each joint and for each packed value by name, and the known words."""

    joints: tuple[Scale, ...]
    values: tuple[tuple[str, Scale], ...]
    modes: tuple[str, ...]

    @classmethod
    def of(cls, spec: Spec) -> "Layout | None":
        """Return the layout; None where the spec has no scale for one of the numbers that its states tell."""
        told = [channel.name for channel in spec.packed()]
        if any(name not in spec.scales for name in (*spec.joints, *told)):
            return None
        return cls(
            tuple(spec.scales[name] for name in spec.joints), tuple((name, spec.scales[name]) for name in told),
            tuple(str(mode) for mode in spec.modes),
        )  # fmt: skip

    @cached_property
    def mode_bits(self) -> int:
        """Return the bits of a word's number; all ones stand for a word that follows as text."""
        return len(self.modes).bit_length()

    @cached_property
    def scales(self) -> tuple[Scale, ...]:
        """Return all scales in the order of the packet."""
        return (*self.joints, *(scale for _, scale in self.values))

    @cached_property
    def size(self) -> int:
        """Return the length of a packet in bytes, without a word."""
        return -(-(HEAD_BITS + self.mode_bits + sum(scale.bits for scale in self.scales)) // 8)

    @cached_property
    def mark(self) -> int:
        """Return the first byte: from `FIRST` on, and most likely another for another layout."""
        written = [(scale.low, scale.step, scale.bits) for scale in self.scales]
        return FIRST | zlib.crc32(repr((len(self.joints), written, self.modes)).encode()) & 127

    def facts(self) -> dict[str, Any]:
        """Return what a page needs to read the packets."""
        scales = [[scale.low, scale.step, scale.bits, scale.steps] for scale in self.scales]
        return {"mark": self.mark, "modes": self.modes, "joints": len(self.joints), "scales": scales}

    def encode(self, at_ms: int, state: RobotState, stopped: bool, values: dict[str, float]) -> bytes | None:
        """Return the packet; None where a number is outside its scale, or the state tells other joints.

        `values` are the packed values by name, as `Spec.named` returns them; one that is missing or not finite is
        not known.
        """
        if len(state.joints) != len(self.joints):
            return None
        known = self.modes.index(state.mode) if state.mode in self.modes else (1 << self.mode_bits) - 1
        bits = (self.mark << 18 | at_ms % CLOCK << 2 | state.moving << 1 | stopped) << self.mode_bits | known
        numbers = (*state.joints, *(values.get(name, nan) for name, _ in self.values))
        for scale, number in zip(self.scales, numbers, strict=True):
            code = scale.code(number)
            if code is None:
                return None
            bits = bits << scale.bits | code
        bits <<= 8 * self.size - HEAD_BITS - self.mode_bits - sum(scale.bits for scale in self.scales)
        return bits.to_bytes(self.size, "big") + (b"" if state.mode in self.modes else state.mode.encode())

    def decode(self, data: bytes, near_ms: int) -> tuple[RobotState, bool]:
        """Return the state and whether a stop is latched; `near_ms`: a time at most half a minute from the packet's.

        Its `at` is the packet's stamp (s since 1970), its `ready` is not told, its `values` are the packed ones.
        Raises ValueError for anything else than a packet of this layout.
        """
        if len(data) < self.size or data[0] != self.mark:
            raise ValueError("not a compact state of this layout")
        take = BitReader(data[: self.size], 8).take
        stamp, moving, stopped, known = take(16), take(1), take(1), take(self.mode_bits)
        numbers = [scale.number(take(scale.bits)) for scale in self.scales]
        behind = (near_ms - stamp + CLOCK // 2) % CLOCK - CLOCK // 2
        text = known == (1 << self.mode_bits) - 1
        if known >= len(self.modes) and not text:
            raise ValueError("a word that this layout does not know")
        word = data[self.size :].decode() if text else self.modes[known]
        joints, rest = tuple(numbers[: len(self.joints)]), numbers[len(self.joints) :]
        values = {name: value for (name, _), value in zip(self.values, rest, strict=True) if isfinite(value)}
        at = (near_ms - behind) / 1000
        return RobotState(at, joints, (), bool(moving), True, mode=word, values=values), bool(stopped)
