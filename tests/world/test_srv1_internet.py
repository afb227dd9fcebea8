"""The hall rover at the end of the paper's Internet, 70 to 120 ms each way, in virtual time: what it still keeps."""

import pytest

from robots.contract.errors import Held
from robots.drivers.srv1.rules import crc_of, paper
from tests.world.srv1 import RoverRig
from tests.world.world import World

pytestmark = pytest.mark.django_db(transaction=True)
ONE_WAY_S = 0.12  # at most
BRAKING_S = 0.3
SLOWER = paper().replace("VF 0.4", "VF 0.38")


class Far:
    """The rover behind such a line, a driver, and people in a process of their own."""

    def __init__(self, folder, seed):
        self.world = World(seed)
        self.rig = RoverRig(self.world, folder, link="internet")
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
def far(request, tmp_path):
    made = Far(tmp_path, request.param)
    made.world.sleep(3)
    made.do(made.session.connect)
    yield made
    made.world.close()
    made.rig.close()


def test_a_patrol_goes_on_by_its_permit_takes_other_rules_and_heeds_a_hold(far):
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
    assert isinstance(ended[0], Held)
    begun = far.rig.count("motion")
    far.world.sleep(5)
    assert far.rig.count("motion") == begun


def test_a_velocity_is_forgotten_before_the_next_one_comes(far):
    """So it is driven in short motions: slowly, and never on by itself."""
    ended = far.begin(lambda: far.execute("turn", angle=1.0))
    far.world.until(lambda: ended, 60, "its end")
    assert not isinstance(ended[0], Exception), ended
    ends = [record["end"] for record in far.rig.journal() if record["event"] == "rest"]
    assert set(ends) <= {"silence", "held", "done"}
    assert not far.rig.moving
