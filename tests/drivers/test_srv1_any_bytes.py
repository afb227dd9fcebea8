"""A hold stops the rover whatever bytes it was sent: whole commands, pieces and noise."""

from random import Random

import pytest

from robots.kit.drivers.srv1.extension import (
    HOLD,
    Activate,
    Ask,
    Claim,
    Hold,
    Journal,
    Patrol,
    Permit,
    Velocity,
    encode,
)
from robots.kit.drivers.srv1.framing import ANSWER, Frames
from tests.drivers.srv1_wire import Rig

pytestmark = pytest.mark.django_db(transaction=True)
HALL = (0.0, 0.0, 12.0, 8.0)
COMMANDS = [
    encode(command)
    for command in (
        Claim(7), Ask(), Hold(), Patrol(7, 0), Velocity(7, 0.1, 0.2, 0), Permit(7, 5000, 0.2, HALL), Activate(7, 5), Journal(0),
    )
]  # fmt: skip


def test_whatever_it_is_sent_a_hold_frees_it():
    rig, dice = Rig(), Random(5)
    for _ in range(400):
        data = dice.randbytes(dice.randrange(1, 30))
        if dice.random() < 0.7:
            command = bytearray(
                dice.choice([*COMMANDS, b"M\x28\x28\x05", b"$A01", b"zW05", b"X\x01\x01\xfe", b"I", b"q1"])
            )
            if dice.random() < 0.5:
                command[dice.randrange(len(command))] = dice.randrange(256)
            data = bytes(command) + data
        rig.say(data, dice.choice((0.0, 0.02, 0.3)))
        heard = rig.say(HOLD, 0.1)  # a picture that is being sent is sent to its end
        assert any(frame.letter == "h" for frame in Frames(ANSWER).feed(heard)), data
        assert rig.bench.drive.holding or not rig.bench.drive.moving
    assert not rig.count("crash")
    assert not rig.count("passed")
    assert rig.say(b"V", 2.0).startswith(b"##Version")
    rig.close()
