"""Frames as text, for the live trace."""

import contextlib

from robots.kit.drivers.mercury import protocol as wire
from robots.kit.drivers.mercury.protocol import Error, Frame, Instruction, Reply


def spell(frame: Frame) -> str:
    """Return a frame of a known id as text; impossible numbers are left out."""
    names: type[Instruction] | type[Reply] = Reply if frame.id >= 0x80 else Instruction
    name = names(frame.id).name
    with contextlib.suppress(ValueError):
        if frame.id == Instruction.MOVE_XYZ:
            x, y, z = wire.numbers(frame)
            return f"{name} #{frame.seq} x={x:.1f} y={y:.1f} z={z:.1f} mm"
        if frame.id in (Instruction.AIR, Instruction.SPEED, Instruction.MOVE_THETA):
            return f"{name} #{frame.seq} {wire.numbers(frame)[0]:.3f}"
        if frame.id == Reply.STATE:
            state = wire.unpack_state(frame.payload)
            return f"{name} #{frame.seq} {state.mode.name} boot={state.boot}"
        if frame.id == Reply.NAK:
            return f"{name} #{frame.seq} {Error(wire.unpack_nak(frame.payload)[1]).name}"
    return f"{name} #{frame.seq}"
