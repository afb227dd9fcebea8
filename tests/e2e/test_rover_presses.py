"""A button that is pressed twice on the rover's page, because the line is slow, takes effect once."""

import pytest
from playwright.sync_api import expect

from queueing import services as queue
from robots.kit.clock import SYSTEM
from robots.models import Command, Program, Robot
from tests.conftest import wait_for
from tests.e2e.drawn import blocks
from tests.e2e.test_rover_stick import portal  # noqa: F401 - a fixture

pytestmark = pytest.mark.timed
LATE_MS = 700


@pytest.fixture
def page(portal, visitor):  # noqa: F811
    """The page of somebody whose turn it is, with its cards open."""
    one = visitor().cleared("ada", None)
    Robot.objects.update(turn_s=3600)
    queue.join(portal.robot, one.user, SYSTEM.now())
    queue.tick(SYSTEM.now())
    queue.accept(portal.robot, one.user, SYSTEM.now())
    one.page.goto("/robots/rover/")
    for card in ("#hall-rules", "#mission"):
        one.page.locator(f"{card} > summary").click()
    blocks(one.page)
    return one.page


@pytest.mark.parametrize("button", ["rules-send", "rules-back"])
def test_rules_are_sent_once(page, button):
    pressed = page.locator(f"[data-command={button}]")
    expect(pressed).to_have_attribute("aria-disabled", "false", timeout=30_000)
    pressed.dblclick()
    expect(page.locator("#notice")).to_have_text("The rules are on their way to the rover.")
    wait_for(lambda: Command.objects.filter(kind="rules").exists(), 10, "a command")
    page.wait_for_timeout(LATE_MS)
    assert Command.objects.filter(kind="rules").count() == 1


def test_a_mission_is_saved_and_deleted_once(page):
    asked = []

    def late(route):
        if route.request.method != "GET":
            asked.append(route.request.method)
            page.wait_for_timeout(LATE_MS)
        route.continue_()

    page.route("**/programs/", late)
    page.fill("#program-text", "read\nturn 90\n")
    page.fill("#program-name", "A tour")
    page.locator("[data-program=save]").dblclick()
    expect(page.locator("#program-saved")).to_have_text("Saved.")
    assert asked == ["POST"]
    assert Program.objects.filter(name="A tour").count() == 1
    page.locator("[data-program=delete]").dblclick()
    expect(page.locator("#program-saved")).to_have_text("Deleted.")
    assert asked == ["POST", "DELETE"]
    assert not Program.objects.filter(name="A tour").exists()
