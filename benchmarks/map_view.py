"""The bits a second that map and pose cells need as byte streams, beside a motion JPEG of the same two, in the same run.

The robot explores its maze for `MINUTES` of its own time (`tests/irat_trial.py`); ten times a second its brain's packets
are counted with all headers on the way to a viewer, and the composite's parts are drawn and compressed as the portal does.
Desktop: map and pose cells; phone: the map alone. The camera's pictures are the same in both and are printed apart.
"""

import os
import tempfile
from collections import Counter
from pathlib import Path

from benchmarks.stage import set_up, tell
from robots.kit.contract.streams import HEAD as PACKET
from robots.kit.drivers.irat.brain.messages import Packet
from robots.kit.drivers.irat.composites.decoding import MapShown, with_cells, with_map
from robots.kit.drivers.irat.composites.decoding import silent as no_cells
from robots.kit.drivers.irat.composites.drawing import Pixels, draw_cells, draw_map
from robots.kit.drivers.irat.spec import spec
from robots.kit.packets import state_packet
from tests.irat_trial import Trial, silent

MINUTES = float(os.environ.get("MINUTES", "30"))
FRAME = 4  # bytes of a WebSocket frame's head
PART = "--{}\r\nContent-Type: image/jpeg\r\nContent-Length: 00000\r\n\r\n\r\n"
PAPER = {"desktop_mbit_s": 1.5, "phone_mbit_s": 0.8}  # with the camera
GOAL = 0.1
# of the composites of 780 x 460 and 320 x 480 (robots/kit/drivers/irat/composites/scene.py)
MAP_DESKTOP, CELLS_DESKTOP, MAP_PHONE = (397, 422), (358, 208), (304, 259)


class Viewers:
    """What each way sends."""

    def __init__(self, trial: Trial) -> None:
        self.trial, self.bytes = trial, Counter[str]()
        self._map, self._cells = MapShown(), no_cells()
        self._spec = spec()
        trial.brain.told = self._packet
        trial.each_step = self._draw

    def _packet(self, packet: Packet) -> None:
        size = len(packet.data) + PACKET.size + FRAME
        self.bytes["streams, desktop"] += size
        if packet.stream == "map":
            self.bytes["streams, phone"] += size
            self._map = with_map(self._map, packet.data, packet.key)
        else:
            self._cells = with_cells(self._cells, packet.data, packet.key)

    def _draw(self) -> None:
        state = self.trial.senses.state()
        pose = (*state.pose[:2], state.pose[2]) if state.pose else None
        for way in ("desktop", "phone"):
            self.bytes[f"streams, {way}"] += (
                len(state_packet(1, 1, state, False, self._spec.packed(), self._spec.named(state))) + FRAME
            )
        self.bytes["pictures, desktop"] += _part(draw_map(self._map, pose, (), *MAP_DESKTOP))
        self.bytes["pictures, desktop"] += _part(draw_cells(self._cells, *CELLS_DESKTOP))
        self.bytes["pictures, phone"] += _part(draw_map(self._map, pose, (), *MAP_PHONE))
        self.bytes["camera"] += self.trial.picture_bytes


def _part(pixels: Pixels) -> int:
    from portal.web.composites.drawing import compressed
    from portal.web.composites.parts import BOUNDARY

    return len(PART.format(BOUNDARY.decode())) + len(compressed(pixels))


def main() -> None:
    """Explore, and count."""
    set_up()
    with tempfile.TemporaryDirectory() as folder:
        trial = Trial(Path(folder), width=208)
        viewers = Viewers(trial)
        while trial.now < MINUTES * 60:
            trial.roaming.explore(_free, silent)
    rate = {name: round(8e-6 * size / trial.now, 3) for name, size in viewers.bytes.items()}  # Mbit/s
    shares = {way: rate[f"streams, {way}"] / rate[f"pictures, {way}"] for way in ("desktop", "phone")}
    beside = {"mbit_s": rate, "shares": {way: round(share, 4) for way, share in shares.items()}, "paper": PAPER,
              "experiences": trial.brain.mind.slam.map.count}  # fmt: skip
    worst = max(shares.values())
    tell(
        "map_view",
        worst,
        "of the bytes of the same as motion JPEG, the larger of both",
        f"<= {GOAL}",
        worst <= GOAL,
        beside,
    )


def _free() -> None:
    """Allow everything."""


if __name__ == "__main__":
    main()
