"""The iRat's page without the robot: rows, and an owner's packets of a ring of places, told again and again."""

import math
import threading
import time  # noqa: TID251 - stamps of states
from datetime import timedelta

import pytest

from portal.keep.seeding import add_robot
from robots import bus
from robots.kit.clock import SYSTEM, ms_of
from robots.kit.contract.session import RobotState
from robots.kit.drivers.irat.packets import EARLIER
from robots.kit.packets import state_packet
from robots.models import Lease, Robot
from robots.states import Cycle
from tests.unit.test_irat_vectors import cell_packets, map_packets
from workers.media.streams import Streams

PLACES, RADIUS_M, MAP = 60, 0.8, 4
MODE = "going to somebody's goal"  # the longest: it has to fit on a phone
RING = [[RADIUS_M * math.cos(i * math.tau / PLACES), RADIUS_M * math.sin(i * math.tau / PLACES)] for i in range(PLACES)]
TOLD = {
    "map": MAP, "sequence": 1, "whole": True, "ids": list(range(PLACES)), "poses": RING,
    "links": [[i, (i + 1) % PLACES] for i in range(PLACES)], "route": [], "docks": [29, 30, 31],
    "dock": [-0.9, 0.0],
}  # fmt: skip
VALUES = {"battery": 7.9, "charge": 82.0, "charging": 0.0, "map": MAP, "experiences": PLACES, "docks": 3, "driven": 5.0}
MARGIN_PX, BESIDE_M = 26, 0.05  # round the map, on the canvas and in metres


@pytest.fixture
def portal(roaming):
    """The portal of a test file that imports this."""
    return roaming


class RoamingPortal:
    """The robot's rows as if its owner lived, and a web process; no job begins, because nobody ticks the queue."""

    def __init__(self, web):
        self.robot = add_robot("irat")
        Lease.objects.create(robot=self.robot, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
        Robot.objects.update(cycle=Cycle.READY)
        self.web, self.url = web, web.url
        self._over = threading.Event()
        self._streams = Streams(self.robot.slug, self.robot.spec().streams, SYSTEM)
        self._teller = threading.Thread(target=self._tell, daemon=True)
        self._teller.start()

    def _tell(self):
        spec = self.robot.spec()
        streams = self._streams
        cells = {str(18 * 225 + 7 * 15 + x): value for x, value in ((6, 0.4), (7, 1.0), (8, 0.5))}
        for name, packets in (("map", map_packets([TOLD])[0]), ("cells", cell_packets([cells])[0])):
            streams.take(name, bytes.fromhex(packets[0]["hex"]), True)
        number = 0
        while not self._over.wait(0.25):
            number += 1
            streams.publish()
            pose = (0.0, 0.0, math.pi / 2)
            state = RobotState(time.monotonic(), (), pose, False, True, "", (), (), MODE, VALUES)
            packet = state_packet(number, int(time.time() * 1000), state, False, spec.packed(), spec.named(state))
            bus.publish_state(self.robot.slug, packet)
            bus.publish_compact(self.robot.slug, packet)  # a page on a busy machine asks for these

    def clear(self, why):
        """Let the map be cleared as the robot's brain does; the next one has three places."""
        (old,) = map_packets([TOLD])[0]
        ids, poses, links = list(range(3)), RING[:3], [[0, 1], [1, 2]]
        (new,) = map_packets([TOLD | {"map": MAP + 1, "ids": ids, "poses": poses, "links": links, "docks": []}])[0]
        earlier = EARLIER.pack(1, why, 660.0, ms_of(SYSTEM.now())) + bytes.fromhex(old["hex"])
        self._streams.take("earlier", earlier, True)
        self._streams.take("map", bytes.fromhex(new["hex"]), True)

    def stop(self):
        self._over.set()
        self._teller.join()


def place_on(page, number):
    """Return where that place of the ring is drawn, from the canvas's corner (px)."""
    box = page.locator("#map").bounding_box()
    wide = 2 * (RADIUS_M + BESIDE_M)
    scale = min(box["width"] - 2 * MARGIN_PX, box["height"] - 2 * MARGIN_PX) / wide
    x, y = RING[number]
    return {"x": box["width"] / 2 + x * scale, "y": box["height"] / 2 - y * scale}
