"""Settings that a robot loses with its power are set again before anything moves, also during a turn."""

import pytest

from robots import services
from robots.kit.contract.errors import HardwareFault
from robots.models import Robot
from tests.services.test_lanes import issue, owner, state_of
from workers.commands import rows

pytestmark = [
    pytest.mark.service, pytest.mark.django_db(transaction=True), pytest.mark.usefixtures("installed"),
    pytest.mark.parametrize("which", ["turntable"], indirect=True),
]  # fmt: skip
assert issue and owner  # fixtures that the tests here use


@pytest.fixture
def again(owner):
    """Return a function that switches the table off and on; then its pace is `pace`, and it is connected anew."""
    owner.owned.driver.rest.set()
    owner.connection.connected = True
    assert owner.motion.run_due() is False

    def again(pace):
        owner.owned.driver.pace = pace
        owner.owned.driver.order.clear()
        owner.connection.later(0.0)
        owner.connection.mend()

    return again


def moved(owner, issue):
    """Ask for a motion; return what the table did, and how fast it is."""
    command = issue("turn", angle=1.0)
    owner.motion.run_due()
    assert state_of(command) == "completed"
    return owner.owned.driver.order, owner.owned.driver.pace


def by_staff(owner, people, pace):
    services.configure(owner.owned.robot, people["kim"], "pace", {"pace": pace}, owner.owned.now())
    owner.config.run_due()


def test_what_staff_set_is_set_again(owner, issue, people, again):
    by_staff(owner, people, 0.4)
    again(1.0)
    assert moved(owner, issue) == (["pace", "turn"], 0.4)
    assert moved(owner, issue) == (["pace", "turn", "turn"], 0.4), "once"
    again(1.0)
    assert moved(owner, issue) == (["pace", "turn"], 0.4), "also if it was set again before"


def test_what_an_operator_tried_gives_way_to_what_staff_set(owner, issue, people, again):
    by_staff(owner, people, 0.4)
    issue("pace", pace=1.5)
    owner.config.run_due()
    again(1.5)
    assert moved(owner, issue) == (["turn"], 1.5), "the table has not forgotten it"
    again(1.0)
    assert moved(owner, issue) == (["pace", "turn"], 0.4)


def test_what_nobody_set_is_replaced_by_the_default(owner, issue, again):
    again(0.7)
    assert moved(owner, issue) == (["pace", "turn"], 1.0)
    again(1.0)
    assert moved(owner, issue) == (["turn"], 1.0)


def test_a_setting_that_is_under_way_is_left_alone(owner, issue, again):
    assert rows.claim(issue("pace", pace=0.5), owner.lease.epoch, owner.owned.now())
    again(0.5)
    assert (
        services.settings_to_reset(
            owner.owned.robot, owner.owned.robot.spec().commands, services.open_grant(owner.owned.robot), {"pace": 0.9}
        )
        == []
    )


def test_what_the_robot_does_not_show_cannot_be_told(owner):
    kinds = owner.owned.robot.spec().commands
    assert services.settings_to_reset(owner.owned.robot, kinds, None, {"warmth": 20.0}) == []
    assert len(services.settings_to_reset(owner.owned.robot, kinds, None, {"pace": 0.9})) == 1


def test_nothing_moves_where_it_cannot_be_set_again(owner, issue, people, again):
    def fail():
        raise HardwareFault("The table did not take it.")

    by_staff(owner, people, 0.4)
    again(1.0)
    owner.owned.driver.setting = fail
    mine = issue("turn", angle=1.0)
    owner.motion.run_due()
    assert (state_of(mine), owner.owned.driver.order, owner.connection.connected) == ("queued", [], False)
    assert "pace could not be set back" in Robot.objects.get().reason
