"""An owner stamps with the database's time, whatever the clock of its own host shows."""

import threading
from datetime import timedelta

import numpy as np
import pytest

from robots import bus
from robots.kit.contract.streams import unpack
from robots.kit.packets import Trace, decode, read_state, taken_ms
from robots.models import Frame, Grant
from tests.services.owner import made_owner

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True), pytest.mark.timed]
AHEAD = timedelta(seconds=60)  # of the host's clock


class Still:
    """A camera that sees the same grey wall at once."""

    lock, number = threading.Lock(), 0

    def grab(self, exposure_s):
        return np.full((48, 64), 90, np.uint8)

    def next(self):
        self.number += 1
        return self.number


@pytest.fixture
def owner(robot, people, redis_server, settings, tmp_path):
    settings.MEDIA_ROOT = tmp_path
    made = made_owner(robot, people)
    made.lease.offset = -AHEAD
    made.now_ms = int((made.clock.now() - AHEAD).timestamp() * 1000)
    return made


def heard(channel, act):
    """Return the message that comes on a channel by what `act` does."""
    with bus.listener() as connections, connections.pubsub(ignore_subscribe_messages=True) as listener:
        listener.subscribe(channel)
        listener.get_message(timeout=30)
        act()
        while (message := listener.get_message(timeout=30)) is None:
            pass
        return message["data"]


def about(at_ms, owner, seconds=30):
    """Tell whether it is the database's time, not the host's, 60 s away."""
    return abs(at_ms - owner.now_ms) < 1000 * seconds


def test_states(owner):
    state = owner.owned.driver.latest()
    owner.owned.age = lambda _: 0.0
    data = heard(bus.state_channel("mercury"), lambda: owner.states._publish(state))
    assert about(1000 * read_state(data, owner.owned.robot.spec().packed()).at, owner)


@pytest.mark.parametrize("which", ["irat"], indirect=True)
def test_byte_streams(owner):
    owner.streams.take("map", b"all of it", True)
    assert about(unpack(heard(bus.stream_channel("irat"), owner.streams.publish)).at_ms, owner)


def test_lines_of_the_trace(owner):
    def act():
        bus.watch("mercury", "trace")
        owner.states._trace.look()
        owner.states._trace.publish("out", b"U", "up", None)

    event = decode(heard(bus.trace_channel("mercury"), act))
    assert isinstance(event, Trace)
    assert about(event.at_ms, owner)


def test_sound(owner):
    assert about(owner.states._sound._now_ms(), owner)


def test_pictures_and_stored_ones(owner):
    owner.pictures.cameras = [Still()]
    state = owner.owned.driver.latest()
    bus.watch("mercury", "frames")
    live = heard(bus.frames_channel("mercury"), lambda: owner.pictures.live_once(state))
    assert about(taken_ms(live), owner)
    stored = heard(bus.frames_channel("mercury"), lambda: owner.pictures.still(state, Grant.objects.get(), None))
    assert about(taken_ms(stored), owner)
    assert about(1000 * Frame.objects.get().taken_at.timestamp(), owner)
