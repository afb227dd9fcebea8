"""A command in few bytes, for slow lines, bit by bit: a motion of an arm of six joints takes at most 24.

A packet is one big-endian number: 8, the digest of the layout, the number of the kind in the spec (7 bits), the
command's sequence number (16), whether the page tells when the picture that it shows was taken, and if so the low 22
bits of that in ms since 1970; then each argument in the order of the spec, an optional one behind a bit that says
whether it is given. An argument that is called like a joint has that joint's scale, a whole number its own steps, any
other number 18 bits of its range. What does not fit, as a text, is sent as JSON.

A keep-alive of a held motion, or its release, is 10, the digest, the number of the kind, the sequence number of the
motion's command, whether it is still held; of a keep-alive each argument follows behind a bit that says whether a newer
value of it is given. A ping is 11 and its number (16 bits). `tests/vectors/command_packets.json`
holds packets that Python and TypeScript write and read alike.
"""

import zlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from robots.kit.contract.bits import BitReader
from robots.kit.contract.spec import Argument, CommandKind, Spec

TYPE, HOLD, PING = 8, 10, 11
HEAD_BITS = 8 + 8 + 7 + 16 + 1
SEEN_BITS, MOST_SEQ, MOST_KINDS = 22, (1 << 16) - 1, 128
FINE = 18  # bits of a number without a scale
MOST_BITS = 32  # of a whole number
SLACK_MS = 60_000  # by which the page's clock may be ahead
LONGEST = 256  # bytes; far more than any command with arguments of this kind


@dataclass(frozen=True)
class Field:
    """An argument: its name and range, the value of code 0, the step and the bits of a code; which ones are required.

    Without bits it is sent as JSON alone.
    """

    name: str
    low: float
    high: float
    first: float
    step: float
    bits: int
    required: bool
    whole: bool = False

    @classmethod
    def of(cls, argument: Argument, spec: Spec) -> "Field":
        """Return how an argument is packed."""
        low, high = argument.low, argument.high
        scale = spec.scales.get(argument.name) if argument.name in spec.joints and argument.unit else None
        if argument.text:
            first, step, bits = low, 1.0, 0
        elif scale is not None and scale.low <= low and high <= scale.high:
            first, step, bits = scale.low, scale.step, scale.bits
        elif argument.whole:
            steps = int(high) - int(low)
            first, step, bits = low, 1.0, max(1, steps.bit_length()) if steps < 1 << MOST_BITS else 0
        else:
            first, step, bits = low, max(high - low, 1e-9) / ((1 << FINE) - 2), FINE  # the middle is one of the steps
        return cls(argument.name, low, high, first, step, bits, argument.required, argument.whole)

    def number(self, code: int) -> float:
        """Return the number of a code, within the argument's range. Raises ValueError for one far outside."""
        found = self.first + code * self.step
        if not self.low - self.step <= found <= self.high + self.step:
            raise ValueError(f"{self.name} lies outside its range")
        return round(found) if self.whole else min(max(found, self.low), self.high)


@dataclass(frozen=True)
class PackedCommand:
    """What a packet says; `seen_ms`: 0 if the page does not tell it."""

    kind: str
    seq: int
    args: dict[str, float]
    seen_ms: int


@dataclass(frozen=True)
class PackedHold:
    """What a keep-alive (`held`) or a release says of the held motion `seq`; `args`: newer values of it."""

    seq: int
    held: bool
    args: dict[str, float]


@dataclass(frozen=True)
class CommandLayout:
    """The kinds of a spec and how their arguments are packed."""

    kinds: tuple[tuple[str, tuple[Field, ...]], ...]

    @classmethod
    def of(cls, spec: Spec) -> "CommandLayout":
        """Return the layout of a robot's commands."""
        given = [c for c in spec.commands if c.asked_by]  # the portal alone gives the others
        return cls(tuple((c.kind, cls._fields(c, spec)) for c in given[:MOST_KINDS]))

    @staticmethod
    def _fields(command: CommandKind, spec: Spec) -> tuple[Field, ...]:
        return tuple(Field.of(argument, spec) for argument in command.arguments)

    @cached_property
    def mark(self) -> int:
        """Return the digest: most likely another for another layout."""
        return zlib.crc32(repr(self.kinds).encode()) & 255

    def facts(self) -> dict[str, Any]:
        """Return what a page needs to write the packets."""
        kinds = [
            [kind, [[f.name, f.low, f.high, f.first, f.step, f.bits, f.required] for f in fields]]
            for kind, fields in self.kinds
        ]
        return {"mark": self.mark, "kinds": kinds}

    def decode(self, data: bytes, now_ms: int) -> PackedCommand:
        """Return the command in a packet; `now_ms`: a time at most an hour after the picture was taken.

        Raises ValueError, with the reason, for anything else than a packet of this layout.
        """
        kind, fields, reader = self._begun(data, TYPE)
        take = reader.take
        seq, seen_ms = take(16), 0
        if not seq:
            raise ValueError("there is no such command")
        if take(1):
            latest = now_ms + SLACK_MS
            seen_ms = latest - (latest - take(SEEN_BITS)) % (1 << SEEN_BITS)
        args = _arguments(reader, [(field, field.required) for field in fields])
        return PackedCommand(kind, seq, args, max(0, seen_ms))

    def decode_hold(self, data: bytes) -> PackedHold:
        """Return the keep-alive or the release in a packet.

        Raises ValueError, with the reason, for anything else than a packet of this layout.
        """
        _, fields, reader = self._begun(data, HOLD)
        seq, held = reader.take(16), bool(reader.take(1))
        if not seq:
            raise ValueError("there is no such command")
        return PackedHold(seq, held, _arguments(reader, [(field, False) for field in fields if held]))

    def _begun(self, data: bytes, what: int) -> tuple[str, tuple[Field, ...], BitReader]:
        """Return the kind that a packet names, its fields, and a reader of what follows. Raises ValueError."""
        if not HEAD_BITS <= 8 * len(data) <= 8 * LONGEST or data[0] != what:
            raise ValueError("this is no command")
        if data[1] != self.mark:
            raise ValueError("the robot's commands have changed")
        reader = BitReader(data, 16)
        index = reader.take(7)
        if index >= len(self.kinds):
            raise ValueError("there is no such command")
        return *self.kinds[index], reader


def _arguments(reader: BitReader, fields: list[tuple[Field, bool]]) -> dict[str, float]:
    """Return the arguments that are left, each field with whether it is always given. Raises ValueError."""
    args = {}
    for field, given in fields:
        if given or reader.take(1):
            if not field.bits:
                raise ValueError(f"{field.name} cannot be packed")
            args[field.name] = field.number(reader.take(field.bits))
    if reader.left >= 8 or reader.rest:
        raise ValueError("something follows its end")
    return args
