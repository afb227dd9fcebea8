"""The owner of a robot with a pose sends where it was at each picture, and how it moves with each state."""

from dataclasses import replace
from struct import unpack_from

import pytest

from robots import bus
from robots.kit.packets import PICTURE_HEAD, read_picture, read_state
from robots.models import Grant
from tests.services.owner import made_owner
from tests.services.test_stamps import Still, heard

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]


@pytest.fixture
def owner(robot, people, redis_server, settings, tmp_path):
    settings.MEDIA_ROOT = tmp_path
    made = made_owner(robot, people)
    made.owned.age = lambda _: 0.0
    return made


@pytest.mark.parametrize("which", ["irat"], indirect=True)
def test_pictures_and_states_tell_where_the_robot_is_and_how_it_moves(owner):
    rolls = replace(owner.owned.driver.latest(), joints=(), pose=(1.0, 2.0, 0.5), twist=(0.25, 0.0, -0.5))
    state = heard(bus.state_channel("irat"), lambda: owner.states._publish(rolls))
    assert read_state(state, owner.owned.robot.spec().packed()).twist == rolls.twist
    owner.pictures.cameras = [Still()]
    bus.watch("irat", "frames")
    for take in (
        lambda: owner.pictures.live_once(rolls), lambda: owner.pictures.still(rolls, Grant.objects.get(), None)
    ):  # fmt: skip
        picture = heard(bus.frames_channel("irat"), take)
        assert unpack_from("<B6f", picture, PICTURE_HEAD.size - 1) == (6, *rolls.pose, *rolls.twist)
        assert read_picture(picture).startswith(b"\xff\xd8")
