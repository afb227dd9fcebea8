"""The hall rover at the end of the paper's slow lines, its radio and its Internet (70 to 120 ms each way)."""

import pytest

from robots.kit.contract.errors import MotionHeld
from robots.kit.drivers.srv1.rules import crc_of, paper
from tests.world.srv1 import RoverRig
from tests.world.world import World

pytestmark = pytest.mark.django_db(transaction=True)
ONE_WAY_S = 0.12  # at most
BRAKING_S = 0.3
SLOWER = paper().replace("VF 0.4", "VF 0.38")


class Far:
    """The rover behind such a line, a driver, and people in a process of their own."""

    def __init__(self, folder, seed, link):
        self.world = World(seed)
        self.rig = RoverRig(self.world, folder, link=link)
        self.session = self.rig.session("srv1", "", {"epoch": 1})
        self.session.on_time_left = lambda: 100.0
        self.process = self.world.process("people", delayed=False)

    def begin(self, act):
        """Call something; return a list that gets what it returned or raised."""
        told = []

        def run():
            try:
                told.append(act())
            except Exception as error:
                told.append(error)

        self.world.spawn(run, "person", self.process)
        return told

    def do(self, act, seconds=120):
        told = self.begin(act)
        self.world.until(lambda: told, seconds, "the end of a call")
        if isinstance(told[0], Exception):
            raise told[0]
        return told[0]

    def execute(self, kind, **args):
        return self.session.execute(kind, args, lambda: None, lambda stage: None)


@pytest.fixture(params=[1, 2])
def make(request, tmp_path):
    """Return a function that puts the rover behind a line, and connects."""
    made = []

    def behind(link="internet"):
        far = Far(tmp_path, request.param, link)
        made.append(far)
        far.world.sleep(3)
        far.do(far.session.connect)
        return far

    yield behind
    for far in made:
        far.world.close()
        far.rig.close()


def test_a_patrol_goes_on_by_its_permit_takes_other_rules_and_heeds_a_hold(make):
    far = make()
    far.do(lambda: far.execute("look"), 300)  # else the patrol begins with it
    ended = far.begin(lambda: far.execute("patrol"))
    far.world.until(lambda: far.rig.count("permit"), 30, "its permit")
    far.world.sleep(1.5)
    rests = far.rig.count("rest")
    sent = far.do(lambda: far.execute("rules", text=SLOWER)).sent
    assert sent == {"crc": crc_of(SLOWER)}
    assert far.rig.sim.firmware.commander.status().rules == crc_of(SLOWER)
    ends = [record["end"] for record in far.rig.journal() if record["event"] == "rest"][rests:]
    assert set(ends) <= {"done"}, "it drives on, also while the line is taken"
    at = far.world.monotonic()
    held = far.begin(far.session.hold)
    far.world.until(lambda: not far.rig.moving, 5, "rest")
    assert far.world.monotonic() - at <= ONE_WAY_S + BRAKING_S
    far.world.until(lambda: held and ended, 10, "both ends")
    assert not held[0].moving
    assert isinstance(ended[0], MotionHeld)
    begun = far.rig.count("motion")
    far.world.sleep(5)
    assert far.rig.count("motion") == begun


@pytest.mark.parametrize("link", ["internet", "radio"])
def test_it_is_led_to_a_place_without_a_rest_between_two_velocities(make, link):
    """A velocity is answered by the status, to which the next one answers: one way there and back each, not two."""
    far = make(link)
    far.do(lambda: far.execute("look"), 300)
    rests, begun = far.rig.count("rest"), far.world.monotonic()
    far.do(lambda: far.execute("go", x=2.0, y=1.0))
    assert far.world.monotonic() - begun < 6.0, "a metre; it took 13 to 22 s"
    ends = [record["end"] for record in far.rig.journal() if record["event"] == "rest"][rests:]
    assert "silence" not in ends
    far.do(lambda: far.execute("turn", angle=1.0))
    assert not far.rig.moving


@pytest.mark.parametrize("link", ["internet", "radio"])
def test_by_hand_it_drives_on_and_rests_when_its_line_is_cut(make, link):
    far = make(link)
    far.begin(lambda: far.execute("drive", forward=0.5, turn=0.0))
    far.world.until(lambda: far.rig.moving, 5, "its motion")
    begun = far.rig.count("motion")
    far.world.sleep(2.0)
    assert far.rig.count("motion") == begun, "one motion"
    at = far.world.monotonic()
    far.rig.pull()
    far.world.until(lambda: not far.rig.moving, 5, "rest")
    assert far.world.monotonic() - at <= 0.5
