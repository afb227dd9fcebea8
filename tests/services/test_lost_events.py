"""An event that Redis did not take: pages are told to read again as soon as it answers."""

import pytest

from robots import bus
from robots.kit.packets import Changed, Notice, decode

pytestmark = [pytest.mark.usefixtures("redis_server"), pytest.mark.timed]
EVENT = Notice("The robot rests.", "info")


@pytest.fixture
def lost(redis_server):
    """An event of one robot that was lost."""
    redis_server.stop()
    try:
        assert not bus.publish("mercury", EVENT)
    finally:
        redis_server.start()


def heard(slug, act):
    """Return the events that a page of the robot hears of what `act` does."""
    with bus.listener() as connections, connections.pubsub(ignore_subscribe_messages=True) as listener:
        listener.subscribe(bus.events_channel(slug))
        listener.get_message(timeout=10)
        act()
        bus.connection().publish(bus.events_channel(slug), b"end")
        told = iter(lambda: listener.get_message(timeout=10)["data"], b"end")
        return [decode(data) for data in told]


@pytest.mark.parametrize(
    "act", [lambda: bus.publish_state("mercury", b"packet"), lambda: bus.publish("mercury", EVENT)]
)
def test_the_next_message_of_that_robot_tells_pages_to_read_again_once(lost, act):
    assert heard("mercury", act).count(Changed("robot")) == 1
    assert Changed("robot") not in heard("mercury", act)


def test_other_robots_hear_nothing_of_it(lost):
    assert heard("pa10", lambda: bus.publish_state("pa10", b"packet")) == []


def test_it_is_tried_again_while_redis_is_away(lost, redis_server):
    redis_server.stop()
    try:
        bus.publish_state("mercury", b"packet")
    finally:
        redis_server.start()
    assert Changed("robot") in heard("mercury", lambda: bus.publish_state("mercury", b"packet"))


def test_a_process_that_says_nothing_more_of_that_robot_makes_up_for_it_too(lost):
    assert heard("mercury", bus.make_up) == [Changed("robot")]
    assert heard("mercury", bus.make_up) == []


def test_a_message_that_could_not_be_made_up_is_made_up_later(lost, redis_server):
    redis_server.stop()
    try:
        bus.make_up()
    finally:
        redis_server.start()
    assert heard("mercury", bus.make_up) == [Changed("robot")]
