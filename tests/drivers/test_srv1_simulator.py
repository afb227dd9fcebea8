"""The hall rover's simulator in virtual time: its firmware drives its body, and what outlives a kill."""

import json
from math import dist

import cv2
import numpy as np
import pytest

from robots.kit.drivers.srv1 import answers, extension, protocol
from robots.kit.drivers.srv1.extension import Ask, Claim, Hold, Patrol, Velocity
from robots.kit.drivers.srv1.framing import ANSWER, Frames
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.protocol import HEADER_BYTES, SIZES, PictureHeader
from simulators.common.rovers.simulator import IDLE_S, KEEP_S
from simulators.srv1.simulator import Simulator
from tests.world.world import World

pytestmark = pytest.mark.django_db(transaction=True)
BOOTED_S = 1.2


class Client:
    """The client of a simulator's link, in memory."""

    name = "the test"

    def __init__(self, world, sim) -> None:
        self.world, self.sim, self.heard, self.is_cut = world, sim, bytearray(), False
        self.frames = Frames(ANSWER)
        assert sim.link.join(self)

    def say(self, data: bytes) -> None:
        self.heard += data

    def cut(self) -> None:
        self.is_cut = True

    def tell(self, data: bytes, seconds: float = 0.1) -> bytes:
        """Send bytes in one piece; return what is answered within that time."""
        self.heard.clear()
        self.sim.link.take(self, data)
        self.world.sleep(seconds)
        return bytes(self.heard)

    def ask(self, command):
        frames = self.frames.feed(self.tell(extension.encode(command)))
        return answers.decode(frames[-1]) if frames else None

    def drive(self, seconds: float, linear: float, angular: float = 0.0, epoch: int = 1):
        """Say a velocity again and again, each with the stamp of the newest answer; return the last answer."""
        until, answer = self.world.monotonic() + seconds, None
        while self.world.monotonic() < until:
            answer = self.ask(Velocity(epoch, linear, angular, self.ask(Ask()).uptime_ms))
        return answer


class Rig:
    """A simulator in a world, in a process of its own."""

    def __init__(self, folder, world=None, **options) -> None:
        self.world = world or World(1)
        self.folder = folder
        self.process = self.world.process("simulator", delayed=False)
        self.sim = Simulator(
            folder, 3, self.world, lambda: self.world.now().timestamp(), self.world, **options
        )  # fmt: skip
        self.world.spawn(self.sim.run, "simulator", self.process)
        self.client = Client(self.world, self.sim)
        self.world.sleep(BOOTED_S)

    def journal(self):
        return [json.loads(line) for line in (self.folder / "journal.jsonl").read_text().splitlines()]

    def rest(self) -> str:
        self.world.until(lambda: not self.sim.moving, 5, "rest")
        self.world.check_errors()
        return [note["end"] for note in self.journal() if note["event"] == "rest"][-1]


@pytest.fixture
def opened(tmp_path):
    made = []

    def begin(**options):
        made.append(Rig(tmp_path, **options))
        return made[-1]

    yield begin
    made[0].world.close()
    for one in made:
        one.sim.journal.close()


@pytest.fixture
def rig(opened):
    return opened()


def test_it_boots_at_home_and_says_what_its_sensors_read(rig):
    assert rig.sim.status()["pose"] == pytest.approx(hall().home, abs=0.01)
    assert rig.client.tell(b"V").startswith(b"##Version")
    status = rig.client.ask(Ask())
    assert (status.x, status.y) == pytest.approx(hall().home[:2], abs=0.05)
    assert status.boot == rig.sim.status()["boot"] == 1
    assert 8.0 < status.volts <= 8.4
    assert 15 < status.temperature < 25
    assert status.sonar > 3


def test_letters_and_velocities_drive_it(rig):
    rig.client.tell(protocol.motion(60, 60, 0.8), 1.5)
    assert rig.rest() == "done"
    way = rig.sim.status()["pose"][0] - hall().home[0]
    assert 0.1 < way < 0.4
    rig.client.ask(Claim(1))
    answer = rig.client.drive(2.0, 0.2)
    assert answer.motion == 2
    assert rig.rest() == "silence"
    status, told = rig.sim.status(), rig.client.ask(Ask())
    assert status["pose"][0] - hall().home[0] > way + 0.3
    assert (told.x, told.y) == pytest.approx(status["pose"][:2], abs=0.05), "its own odometry"
    assert rig.sim.journal.counts["passed"] == 0


def test_a_hold_brakes_at_once(rig):
    rig.client.ask(Claim(1))
    rig.client.drive(1.0, 0.3)
    at = rig.sim.status()["pose"]
    rig.client.ask(Hold())
    assert rig.rest() == "held"
    assert dist(at[:2], rig.sim.status()["pose"][:2]) < 0.3**2 / (2 * 1.6) + 0.05
    assert rig.client.ask(Ask()).end == "held"


@pytest.mark.parametrize("size", SIZES)
def test_pictures_have_the_size_of_the_letter(rig, size):
    rig.client.tell(size.letter)
    said = rig.client.tell(b"I", 0.5)
    header = PictureHeader.decode(said[:HEADER_BYTES])
    data = said[HEADER_BYTES:]
    assert header == PictureHeader(size, len(data))
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (size.height, size.width, 3)


def test_faults_of_the_camera(rig):
    assert (rig.sim.picture(160) != rig.sim.picture(160)).any()
    rig.sim.faults.set("cam_freeze")
    assert (rig.sim.picture(160) == rig.sim.picture(160)).all()
    assert rig.sim.picture(320).shape == (240, 320, 3)
    rig.sim.faults.set("cam_black")
    assert rig.sim.picture(160).max() < 10
    rig.sim.faults.set("cam_gone")
    assert rig.sim.picture(160) is None
    assert rig.client.tell(b"I", 0.2) == b""


def test_a_camera_that_is_busy_gives_no_picture(rig):
    rig.sim.faults.set("cam_slow", 0.5)
    rig.world.spawn(lambda: rig.sim.picture(160), "another", rig.process)
    rig.world.sleep(0.1)
    assert rig.sim.picture(160) is None
    rig.sim.faults.clear()
    rig.world.sleep(0.6)
    assert rig.sim.picture(160) is not None


def test_at_rest_its_loop_turns_ten_times_a_second(rig):
    rig.world.sleep(2.0)
    ticks, tick = [], rig.sim.world.tick
    rig.sim.world.tick = lambda *seconds: (ticks.append(seconds), tick(*seconds))
    at, physics = rig.sim.world.now, rig.sim.world.plant._data.time
    rig.world.sleep(10.0)
    assert len(ticks) <= 10 / IDLE_S + 1
    assert rig.sim.world.plant._data.time == physics
    assert rig.sim.world.now - at == pytest.approx(10.0, abs=0.2), "its time passes all the same"


def test_pose_charge_and_boot_number_outlive_a_kill(rig, opened):
    rig.client.ask(Claim(1))
    rig.client.drive(2.0, 0.2, 0.3)
    rig.rest()
    rig.world.sleep(2 * KEEP_S + 10)
    before = rig.sim.status()
    rig.world.kill(rig.process)
    again = opened(world=rig.world).sim.status()
    assert again["pose"] == pytest.approx(before["pose"], abs=1e-3)
    assert again["charge"] == pytest.approx(before["charge"], abs=1e-3)
    assert again["boot"] == before["boot"] + 1
    assert max(map(abs, again["encoders"])) <= 2, "they count anew, and it stands on soft wheels"


def test_a_kill_in_mid_motion_loses_little_of_its_way(rig, opened):
    rig.client.ask(Claim(1))
    rig.client.drive(3.0, 0.3)
    before = rig.sim.status()["pose"]
    rig.world.kill(rig.process)
    again = opened(world=rig.world).sim.status()
    assert before[0] > hall().home[0] + 0.6
    assert dist(again["pose"][:2], before[:2]) < 0.24, "what it drives in 0.8 s"
    assert not again["moving"]


def test_a_power_cycle_ends_connection_and_motion_and_counts_from_zero(rig):
    rig.client.ask(Claim(1))
    rig.client.drive(1.0, 0.2)
    rig.sim.faults.set("power_cycle", count=1)
    rig.world.sleep(0.1)
    assert rig.client.is_cut
    assert rig.rest() == "lost"
    status = rig.sim.status()
    assert status["boot"] == 2
    assert max(map(abs, status["encoders"])) < 40, "what it still rolled"
    rig.world.sleep(BOOTED_S)
    client = Client(rig.world, rig.sim)
    told = client.ask(Ask())
    assert (told.boot, told.epoch) == (2, 0)


def test_without_charge_nobody_reaches_it_until_its_cells_are_changed(rig):
    rig.sim.faults.set("charge", 0.01)
    rig.world.sleep(0.3)
    assert rig.client.is_cut
    assert not rig.sim.status()["power"]
    rig.world.sleep(62)
    assert rig.sim.status()["power"]
    events = [n["event"] for n in rig.journal()]
    assert events.index("flat") < events.index("cells_changed") < events.index("power_back")
    rig.world.sleep(BOOTED_S)
    assert Client(rig.world, rig.sim).ask(Ask()).volts > 8.0


def test_who_carries_it_away_is_seen_by_judges_and_not_by_its_odometry(rig):
    rig.sim.faults.set("carried", 7)
    rig.world.sleep(0.3)
    x, y, _ = rig.sim.status()["pose"]
    told = rig.client.ask(Ask())
    assert dist((told.x, told.y), hall().home[:2]) < 0.1
    assert dist((x, y), hall().home[:2]) > 0.5


def test_a_status_carries_the_beacon_where_there_is_one(rig, opened):
    assert rig.client.ask(Ask()).beacon is None
    other = opened(beacon=True)
    for _ in range(5):
        told = other.client.ask(Ask())
        away, bearing = told.beacon
        x, y, _ = other.sim.status()["pose"]
        assert hall().tower[1] + away * np.sin(bearing) == pytest.approx(y, abs=2.2)  # it may come by a reflection
        assert bearing == pytest.approx(np.arctan2(y - hall().tower[1], x - hall().tower[0]), abs=0.13)
    other.sim.faults.set("beacon_gone")
    assert other.client.ask(Ask()).beacon is None


def test_a_stock_rover_is_silent_to_what_is_ours(opened):
    rig = opened(stock=True)
    assert rig.client.ask(Ask()) is None
    assert rig.client.tell(b"V").startswith(b"##Version")


def test_by_radio_a_picture_takes_seconds(opened):
    rig = opened(link="radio")
    rig.world.sleep(1.0)
    assert rig.client.tell(b"V", 0.03) == b""
    rig.world.sleep(1.0)
    assert rig.client.tell(b"I", 1.0)[:5] in (b"", b"##IMJ")
    assert len(rig.client.heard) < 1000
    rig.world.sleep(20.0)
    assert len(rig.client.heard) > 4000


def test_what_is_in_the_flash_memory_outlives_a_kill(rig, opened):
    text = b"a rule set"
    rig.sim._flash.load(text)
    assert rig.client.tell(b"zw").startswith(b"##zwrite")
    rig.world.sleep(11.0)
    rig.world.kill(rig.process)
    assert opened(world=rig.world).sim._flash.user == text


def test_on_patrol_it_drives_far_and_touches_nothing(rig):
    rig.client.ask(Claim(1))
    touched = set()
    for _ in range(300):
        rig.client.ask(Patrol(1, rig.client.ask(Ask()).uptime_ms))
        touched.update(rig.sim.world.plant.contacts)
    assert rig.sim.world.driven > 2.5
    assert not touched
    assert rig.rest() == "silence"
