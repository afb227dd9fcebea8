"""Two pages of one operator give different commands the same number: the second learns that its own did not run."""

import asyncio

import pytest

from portal.live import actions, robot_socket
from portal.live.loop import LoopState
from portal.live.messages import Command as Asked
from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Command, Frame
from robots.services.commands import NumberUsed, _write
from tests.conftest import CALIBRATION
from tests.services.browsers import signed_in

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def now():
    return SYSTEM.now()


@pytest.fixture
def scope(people):
    """The scope of a socket of Ada's."""
    browser = signed_in(people["ada"])
    return {"cookies": {name: one.value for name, one in browser.cookies.items()}}


def click(robot, people, number, still, u=150.0):
    return services.issue(robot.slug, people["ada"], "click", {"still": still.pk, "u": u, "v": 40}, number)


def picture(robot):
    return Frame.objects.create(
        robot=robot, taken_at=now(), file="frames/x.jpg", width=192, height=165, pose=[0.0, 0.42, 0.0, 0.0],
        joints=[1, 1, 0, 0], calibration=CALIBRATION,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "args"),
    [("down", {}), ("move", {"x": 0.1, "y": 0.4}), ("move", []), ("fly", {}), ("click", {"still": 1, "u": 1, "v": 1})],
)
def test_another_command_with_a_number_that_is_used_is_told_that_it_was_not_carried_out(
    robot, people, grant, scope, kind, args
):
    services.issue(robot.slug, people["ada"], "up", {}, 7)
    with pytest.raises(NumberUsed, match="not carried out: another page of yours"):
        services.issue(robot.slug, people["ada"], kind, args, 7)
    if isinstance(args, dict):
        told = actions.act(scope, robot.slug, Asked(kind=kind, args=args, seq=7))
        assert (told.ok, told.code, told.extra) == (False, "number_used", {})
        assert told.changed, "so that the page hears of the next number"
    assert Command.objects.count() == 1


def test_the_same_values_are_the_same_command_and_others_are_not(robot, people, grant):
    first = services.issue(robot.slug, people["ada"], "move", {"x": 0.1, "y": 0.4}, 1)
    assert services.issue(robot.slug, people["ada"], "move", {"y": 0.4, "x": 0.1}, 1).command == first.command
    with pytest.raises(NumberUsed):
        services.issue(robot.slug, people["ada"], "move", {"x": 0.1, "y": 0.41}, 1)


def test_a_click_is_compared_by_its_picture_also_when_there_is_a_newer_one(robot, people, grant):
    still = picture(robot)
    first = click(robot, people, 1, still)
    picture(robot)
    assert click(robot, people, 1, still).command == first.command
    with pytest.raises(NumberUsed):
        click(robot, people, 1, still, u=30.0)


def test_two_that_come_at_the_same_moment_are_told_apart(robot, people, grant, owned):
    """Both have found the number free; the database keeps one row."""
    ada = people["ada"]
    written = _write(robot, ada, grant, owned.epoch, "up", {}, 1, 10.0, now())
    assert written.created
    again = _write(robot, ada, grant, owned.epoch, "up", {}, 1, 10.0, now())
    assert (again.command, again.created) == (written.command, False)
    with pytest.raises(NumberUsed):
        _write(robot, ada, grant, owned.epoch, "down", {}, 1, 10.0, now())


def test_a_press_that_was_refused_holds_no_motion_of_another_page(robot, people, grant, scope, monkeypatch):
    monkeypatch.setattr("robots.bus.publishing.send", lambda channel, data: True)
    services.issue(robot.slug, people["ada"], "up", {}, 7)
    page = robot_socket.RobotSocket()
    page.scope = {**scope, "url_route": {"kwargs": {"slug": robot.slug}}}
    page.shared = LoopState()
    page.prepare()
    requests, controls = page.requests, page.controls
    controls._pressed = 7
    asked = Asked(kind="down", args={}, seq=7)
    answers, refused = [], actions.act(scope, robot.slug, asked)

    async def here(*_):
        return refused

    async def answered(message, answer):
        answers.append(answer)
        raise asyncio.CancelledError

    page.orm, requests.answer = here, answered

    async def served():
        requests._queue.put_nowait((asked, False))
        with pytest.raises(asyncio.CancelledError):
            await requests.run()

    asyncio.run(served())
    assert [one.code for one in answers] == ["number_used"]
    assert controls._pressed == controls._command == 0
