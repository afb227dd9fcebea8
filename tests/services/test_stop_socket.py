"""A Stop pressed on a page's socket names the grant that the socket was told last."""

import asyncio
from datetime import timedelta

import pytest

from portal.live import robot_socket, snapshot_sender
from portal.live.loop import LoopState
from portal.live.messages import Stop
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.models import Robot
from robots.services.status import status_of
from robots.states import Cycle, GrantEnd, GrantKind

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def page(robot, people, monkeypatch):
    """Return a function that makes a person's socket, as it is after its first snapshot."""

    def of(name):
        monkeypatch.setattr(snapshot_sender, "current_user", lambda scope: people[name])
        made = robot_socket.RobotSocket()
        made.scope = {"url_route": {"kwargs": {"slug": robot.slug}}}
        made.shared = LoopState()
        made.prepare()
        _, made.role, _ = made.snapshots.read(True)
        return made

    return of


@pytest.fixture
def sent(monkeypatch):
    words = []
    monkeypatch.setattr("robots.bus.publishing.send", lambda channel, data: words.append(data) or True)
    return words


def press(page):
    asyncio.run(page.take(Stop()))


def begin(robot, person):
    now = SYSTEM.now()
    return services.start_grant(robot, GrantKind.TURN, now, person, now + timedelta(minutes=5))


def test_a_page_that_missed_the_end_of_its_turn_names_that_turn(robot, people, owned, page, sent):
    before = begin(robot, people["ada"])
    ada = page("ada")
    services.end_grant(before, GrantEnd.STAFF, "over", SYSTEM.now())
    begin(robot, people["bob"])
    press(ada)  # it was kept from reading, so it knows no better
    assert [bus.grant_of_stop(word) for word in sent] == [before.pk]
    with pytest.raises(NotPermitted):
        services.stop(robot, people["ada"], sent=True)
    assert not Robot.objects.get().stop_latched


def test_staff_stop_whoever_operates_and_others_send_nothing(robot, people, owned, page, sent):
    begin(robot, people["ada"])
    press(page("kim"))
    assert sent == [b"stop"]
    press(page("bob"))
    assert sent == [b"stop"]


@pytest.mark.parametrize("cycle", [Cycle.OPERATING, Cycle.READY, Cycle.HANDOVER])
def test_everybody_is_told_that_a_robot_is_stopped_also_in_a_turn(robot, owned, cycle):
    Robot.objects.update(cycle=cycle, stop_latched=True)
    told = status_of(Robot.objects.get(), SYSTEM.now())
    assert told == ("stopped", "Stopped", "Stopped. Release needs a look at the picture.")
