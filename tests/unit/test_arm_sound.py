"""What is heard of the simulated Mercury: its motors, its air, and a quiet room."""

import numpy as np
import pytest

from robots.kit.description import load
from simulators.common.microphone import BLOCK_S, RATE
from simulators.mercury.arm import Body, Pose
from simulators.mercury.sound import ROOM, ArmSound
from simulators.mercury.workspace import Workspace

COUNT = int(RATE * BLOCK_S)
SPACE = Workspace(load("mercury"))
HOME = Pose(0.0, 0.42, 0.075, 0.0)


class Heard:
    def __init__(self):
        self.body, self.open, self.at = Body(HOME, 0.0), False, 0.0
        self._ear = ArmSound(self.body, SPACE, lambda: self.open)

    def blocks(self, many):
        found = []
        for _ in range(many):
            self.body.advance_to(self.at + BLOCK_S)
            found.append(self._ear.hear(self.at, self.at + BLOCK_S, COUNT))
            self.at += BLOCK_S
        return np.array(found)


def level(samples):
    return float(np.sqrt(np.mean(np.square(samples, dtype=float))))


def pitch(samples):
    samples = samples.ravel()
    power = np.abs(np.fft.rfft(samples * np.hanning(samples.size))) ** 2
    return float((power * np.fft.rfftfreq(samples.size, 1 / RATE)).sum() / power.sum())


def test_a_room_at_rest_is_quiet():
    assert level(Heard().blocks(20)) == pytest.approx(ROOM, rel=0.1)


def test_a_motion_is_heard_and_a_faster_one_is_louder():
    levels = []
    for speed in (0.05, 0.3):
        heard = Heard()
        heard.body.start(Pose(0.18, 0.52, 0.075, 0.0), speed)
        levels.append(level(heard.blocks(12)[9:]))
    assert 5 * ROOM < levels[0] < levels[1]
    assert levels[1] < 0.5, "it does not overdrive"


def test_a_motor_sounds_higher_the_faster_it_turns():
    heard = Heard()
    heard.body.start(Pose(0.2, 0.42, 0.075, 0.0), 0.4)
    blocks = heard.blocks(8)
    assert pitch(blocks[1]) < pitch(blocks[3]) < pitch(blocks[6])


def test_the_sound_has_no_steps_between_its_blocks():
    heard = Heard()
    heard.body.start(Pose(0.18, 0.52, 0.075, 0.0), 0.3)
    blocks = heard.blocks(20)
    steps = np.abs(np.diff(blocks.ravel()))
    between = steps[COUNT - 1 :: COUNT]
    assert between.max() <= np.quantile(steps, 0.999)


def test_air_hisses_while_it_blows_and_the_arm_falls_silent_again():
    heard = Heard()
    heard.blocks(2)
    heard.open = True
    assert level(heard.blocks(4)[1:]) > 20 * ROOM
    heard.open = False
    assert level(heard.blocks(4)[1:]) == pytest.approx(ROOM, rel=0.2)
