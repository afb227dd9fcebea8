"""Who watches a robot that rolls sees where the driver sends it, on its map and in three dimensions."""

from playwright.sync_api import expect

from robots.kit.clock import SYSTEM
from robots.models import Command
from robots.states import CommandState
from tests.e2e.test_stage import portal as portal
from tests.e2e.test_target import begun
from tests.e2e.test_target import pages as pages
from workers.commands.rows import finish


def test_who_watches_the_rover_sees_where_it_goes_on_the_map_and_in_three_dimensions(portal, pages):
    _, watcher = pages("srv1")
    robot, hall = portal.robots["srv1"], watcher.page.locator("#hall-3d")
    grant = robot.grants.get(ended_at=None)
    Command.objects.create(
        robot=robot, grant=grant, client_seq=1, issued_by=grant.holder, kind="go", args={"x": 10.5, "y": 1.5}, epoch=1,
        created_at=SYSTEM.now(), deadline=SYSTEM.now(),
    )  # fmt: skip
    watcher.page.locator("#deep").click()
    expect(hall.locator("canvas")).to_be_visible(timeout=30_000)
    expect(hall).not_to_have_attribute("data-goes", "")
    command = begun(portal, "srv1", None)
    expect(watcher.page.locator("#target")).to_have_text(command.target["words"])
    expect(hall).to_have_attribute("data-goes", "")
    finish(command, CommandState.COMPLETED, SYSTEM.now())
    expect(hall).not_to_have_attribute("data-goes", "")
