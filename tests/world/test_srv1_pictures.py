"""The hall rover's pictures over lines of several speeds, in virtual time, and what a look around does with them."""

import cv2
import numpy as np
import pytest

from robots.kit.contract.errors import MotionHeld
from robots.kit.contract.session import Observation
from robots.kit.drivers.srv1.pictures import NONE
from robots.kit.drivers.srv1.protocol import SIZES
from tests.world.srv1 import RoverRig
from tests.world.world import World

BOOT_S = 3.0


@pytest.fixture
def driven(tmp_path):
    """Return what runs a function with a rig and its connected session, as a process of the world."""

    def run(act, **options):
        world, ended = World(1), []
        rig = RoverRig(world, tmp_path / "rig", **options)

        def person():
            world.sleep(BOOT_S)
            session = rig.session("srv1", "", {"epoch": 1})
            session.connect()
            ended.append(act(rig, session))

        world.spawn(person, "person", world.process("person", delayed=False))
        try:
            world.until(lambda: ended, 600, "the end")
        finally:
            world.close()
            rig.close()
        return ended[0]

    return run


def several_statuses(session):
    for _ in range(10):
        session.state()


def test_a_picture_is_as_large_as_the_line_carries_soon_enough(driven):
    def sizes(rig, session):
        found = []
        for late_s in (0.0, 0.035, 0.2, 0.0):  # in each direction
            rig.fault("slow", late_s)
            several_statuses(session)
            data = session.picture("rover", 3.0)
            found.append(data and cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR).shape[1])
        return found

    assert driven(sizes) == [320, 160, None, 320]


def test_a_size_that_noise_has_changed_is_asked_for_again(driven):
    def after(rig, session):
        session.picture("rover", 3.0)
        session.wheels.line.letters(SIZES[3].letter, lambda data: True if b"#d" in data else None)
        seen = [session.picture("rover", 3.0) for _ in range(2)]
        return [cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR).shape[1] for data in seen]

    assert driven(after) == [1280, 320], "the header of the first one tells it"


def test_by_radio_a_look_around_takes_no_pictures_and_says_so(driven):
    def look(rig, session):
        told = []
        session.execute("mission", {"text": "look around\nphotograph"}, lambda: None, told.append)
        return [one for one in told if isinstance(one, Observation)], rig.sim.pictures

    noted, pictures = driven(look, link="radio")
    assert [one.text for one in noted[:2]] == [f"looks around {NONE}", "look 1 of 18"]
    assert noted[-1].text == f"photograph {NONE}"
    assert len(noted) == 20
    assert not any(one.photograph for one in noted)
    assert set(noted[1].values) == {"compass", "infrared", "sonar"}
    assert pictures == 0, "none was asked for"


def test_a_hold_while_a_picture_of_a_look_around_is_taken_ends_it(driven):
    def held(rig, session):
        told = []

        def on_stage(stage):
            told.append(stage)
            if isinstance(stage, Observation):
                session.hold()

        try:
            session.execute("look", {}, lambda: None, on_stage)
        except MotionHeld:
            return sum(isinstance(one, Observation) for one in told), session.state().moving
        return None

    assert driven(held) == (1, False)
