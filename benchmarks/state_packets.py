"""Updates a second of an arm's state over a line of 1 kB/s, beside the paper's figure, and how exact they are.

The line carries compact states and, every five seconds, a whole one. Counted are WebSocket's bytes, then the same with
TCP/IP headers, each state in a packet of its own. The place of the tool is compared in random poses.
"""

import math
import time

import numpy as np

from benchmarks.stage import tell

LINE, WHOLE_EVERY_S = 1000, 5.0
PAPER_BYTES, PAPER_HZ = 42, 12  # Belousov et al. 2001: a state, and updates a second on a line of 1 kB/s
TCP_IP = 20 + 32  # bytes of the headers, with time stamps
POSES = 20_000
MOST, MOST_OBJECT, MOST_MM, MOST_DEG = 20, 12, 0.05, 0.05


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
    from robots.kit.contract.streams import HEAD as STREAM_HEAD
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
    rates = {}
    for name, more in (("websocket", 0), ("tcp_ip", TCP_IP)):
        left = LINE - (whole + 4 + more) / WHOLE_EVERY_S
        rates[name] = left / (layout.size + 2 + more)
    flying = (LINE - (whole + 4) / WHOLE_EVERY_S) / (layout.size + 2 + STREAM_HEAD.size + object_bytes + 2)
    print(
        f"{layout.size} bytes a state (the paper {PAPER_BYTES}), a whole one {whole}; {rates['websocket']:.1f} a second on "
        f"{LINE} bytes/s, {rates['tcp_ip']:.1f} with TCP/IP headers (the paper {PAPER_HZ}); tool at most {far_mm:.3f} mm and "
        f"{turned:.4f} degrees off in {POSES} poses; {took_us:.0f} us to write one; an object {object_bytes} bytes, at most "
        f"{object_mm:.3f} mm and {object_deg:.4f} degrees off; {flying:.1f} a second of the robot and an object that flies"
    )
    beside = {
        "bytes": layout.size, "whole_bytes": whole, "with_tcp_ip": round(rates["tcp_ip"], 1),
        "with_object": round(flying, 1), "most_mm": round(far_mm, 4), "most_deg": round(turned, 4), "write_us": round(took_us, 1),
        "object_bytes": object_bytes, "object_mm": round(object_mm, 4), "object_deg": round(object_deg, 4),
    }  # fmt: skip
    holds = (
        layout.size <= MOST and max(far_mm, object_mm) <= MOST_MM and max(turned, object_deg) <= MOST_DEG
        and object_bytes <= MOST_OBJECT and rates["tcp_ip"] >= PAPER_HZ
    )  # fmt: skip
    tell(
        "state_packets", rates["websocket"], f"updates a second on a line of {LINE} bytes/s",
        f"at most {MOST} bytes, {MOST_OBJECT} an object, {MOST_MM} mm, {MOST_DEG} degrees; {PAPER_HZ} updates a second also with TCP/IP headers",
        holds, beside,
    )  # fmt: skip
