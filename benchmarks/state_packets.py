"""Updates a second of an arm's state over a line of 1 kB/s, beside the paper's figure and others, and how exact.

The line carries compact states and, every five seconds, a whole one; with an object that flies also a delta for each
state. Counted are WebSocket's bytes, then the same with TCP/IP headers, each state in a packet of its own. rosbridge's
JSON and foxglove-sdk say the same numbers of the same arm. The place of the tool is compared in random poses.
"""

import math
import time
from itertools import cycle

import numpy as np

from benchmarks._other_lines import foxglove, rosbridge, with_head
from benchmarks.stage import tell

LINE, WHOLE_EVERY_S = 1000, 5.0
PAPER_BYTES, PAPER_HZ = 42, 12  # Belousov et al. 2001: a state, and updates a second on a line of 1 kB/s
TCP_IP = 20 + 32  # bytes of the headers, with time stamps
POSES = 20_000
MOST, MOST_OBJECT, MOST_MM, MOST_DEG = 20, 12, 0.05, 0.05
ALONE_HZ, FLYING_HZ = 40, 25


def updates(whole: int, *sizes: int, more: int = 0) -> float:
    """Return how often a second frames of these sizes (bytes) pass together, beside whole states."""
    return (LINE - (with_head(whole) + more) / WHOLE_EVERY_S) / sum(size + more for size in sizes)


def counted(whole: int, *sizes: int, seconds: float = 60.0) -> float:
    """Return how often a second frames of these sizes pass through the portal's window, which measures the line.

    Its pings are bytes, too. The line is the one of the window's own test: 300 ms there and back, in virtual time.
    """
    from tests.unit.test_window import Line

    line, frames, passed, told = Line(LINE, 0.15), cycle(sizes), 0, 0.0
    while line.now < 2 * seconds:
        while not line.window.full:
            if line.now >= told:
                line.write(with_head(whole))
                told += WHOLE_EVERY_S
            line.write(next(frames))
            passed += line.now >= seconds
        line.step()
    return passed / len(sizes) / seconds


def others(names: list[str], joints: list[float]) -> dict[str, dict[str, float]]:
    """Return of each other way the bytes of a frame with the joints and of one with an object, and updates a second."""
    place, rotation = [0.412345, -0.123456, 0.234567], [0.182574, 0.365148, 0.547723, 0.730297]
    found = {}
    for name, way in (("rosbridge", rosbridge), ("foxglove_sdk", foxglove)):
        arm, brick = way(names, joints, place, rotation)
        found[name] = {
            "bytes": arm, "object_bytes": brick, "alone": round(LINE / arm, 1), "with_object": round(LINE / (arm + brick), 1),
            "with_tcp_ip": round(LINE / (arm + TCP_IP), 1),
        }  # fmt: skip
    return found


def objects(rng: np.random.Generator) -> tuple[int, float, float]:
    """Return the bytes of an object, and how far (mm) and turned (degrees) it is at most from where it was said to be."""
    from scipy.spatial.transform import Rotation

    from robots.kit.contract.objects import Box, Placed

    box = Box((-1.5, -1.5, -0.2), (3.0, 3.0, 2.0))
    places = rng.uniform(box.low, np.add(box.low, box.size), (POSES, 3))
    turns = Rotation.random(POSES, rng)
    packets = [box.encode(1, Placed(tuple(p), tuple(q))) for p, q in zip(places, turns.as_quat(), strict=True)]
    found = [placed for packet in packets if (placed := box.decode(packet)[1])]
    far = np.linalg.norm(places - [placed.place for placed in found], axis=1).max()
    turned = (turns.inv() * Rotation.from_quat([placed.rotation for placed in found])).magnitude().max()
    return max(map(len, packets)), float(far) * 1000, math.degrees(float(turned))


def main() -> None:
    """Measure the museum arm, and objects."""
    from robots.kit.arms.described import chain
    from robots.kit.contract.compact import Layout
    from robots.kit.contract.session import RobotState
    from robots.kit.contract.short_heads import SHORT
    from robots.kit.drivers.pa10.spec import spec
    from robots.kit.packets import state_packet

    arm, layout = chain("pa10"), Layout.of(spec())
    assert layout is not None
    rng = np.random.default_rng(1)
    poses = rng.uniform([j.low for j in arm.joints], [j.high for j in arm.joints], (POSES, len(arm.joints)))
    states = [RobotState(0.0, (*q, 0.02), (), True, True, mode="JOINT CTRL") for q in poses]
    begun = time.perf_counter()
    packets = [layout.encode(n, state, False, {}) for n, state in enumerate(states)]
    took_us = (time.perf_counter() - begun) / POSES * 1e6
    read = [layout.decode(packet or b"", n)[0] for n, packet in enumerate(packets)]
    wanted, found = arm.forward(poses), arm.forward(np.array([state.joints[:-1] for state in read]))
    far_mm = float(np.linalg.norm(wanted[:, :3, 3] - found[:, :3, 3], axis=1).max() * 1000)
    cosines = (np.einsum("nij,nij->n", wanted[:, :3, :3], found[:, :3, :3]) - 1) / 2
    turned = math.degrees(math.acos(min(1.0, float(cosines.min()))))
    object_bytes, object_mm, object_deg = objects(rng)
    rows = ((0.0,) * 7,) * 3
    whole = len(state_packet(1, 0, RobotState(0.0, rows[0], (), True, True, "", rows[1], rows[2], "JOINT CTRL"), False))
    state, brick = with_head(layout.size), with_head(SHORT.size + object_bytes)
    rates = {"websocket": updates(whole, state), "tcp_ip": updates(whole, state, more=TCP_IP)}
    rates["counted"], flying = counted(whole, state), counted(whole, state, brick)
    beside_us = others([*(j.name for j in arm.joints), "gripper"], [*map(float, poses[0]), 0.02])
    print(
        f"{layout.size} bytes a state (the paper {PAPER_BYTES}), a whole one {whole}; {rates['websocket']:.1f} a second on "
        f"{LINE} bytes/s, {rates['counted']:.1f} with the window's pings, {rates['tcp_ip']:.1f} with TCP/IP headers (the paper {PAPER_HZ}); tool at most {far_mm:.3f} mm and "
        f"{turned:.4f} degrees off in {POSES} poses; {took_us:.0f} us to write one; an object {object_bytes} bytes, at most "
        f"{object_mm:.3f} mm and {object_deg:.4f} degrees off; {flying:.1f} a second of the robot and an object that flies; beside it {beside_us}"
    )
    beside = {
        "bytes": layout.size, "whole_bytes": whole, "with_tcp_ip": round(rates["tcp_ip"], 1), "with_pings": round(rates["counted"], 1),
        "with_object": round(flying, 1), "most_mm": round(far_mm, 4), "most_deg": round(turned, 4), "write_us": round(took_us, 1),
        "object_bytes": object_bytes, "object_mm": round(object_mm, 4), "object_deg": round(object_deg, 4),
        **beside_us,
    }  # fmt: skip
    holds = (
        layout.size <= MOST and max(far_mm, object_mm) <= MOST_MM and max(turned, object_deg) <= MOST_DEG
        and object_bytes <= MOST_OBJECT and rates["tcp_ip"] >= PAPER_HZ
        and rates["counted"] >= ALONE_HZ and flying >= FLYING_HZ
    )  # fmt: skip
    tell(
        "state_packets", rates["websocket"], f"updates a second on a line of {LINE} bytes/s",
        f"at most {MOST} bytes, {MOST_OBJECT} an object, {MOST_MM} mm, {MOST_DEG} degrees; {ALONE_HZ} updates a second, {FLYING_HZ} with an object that flies, {PAPER_HZ} with TCP/IP headers",
        holds, beside,
    )  # fmt: skip
