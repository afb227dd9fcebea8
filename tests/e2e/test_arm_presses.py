"""A button of an arm's console that is pressed twice sends one command, also before the server has answered the first."""

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import session
from tests.e2e.test_stage import portal as portal
from tests.waiting import CEILING_S, wait_for

# both presses are before any answer, however fast the server is
TWICE = "(button) => { button.click(); button.click(); }"


@pytest.mark.parametrize(("robot", "name"), [("pa10", "open"), ("pa10", "ready"), ("puma", "ready")])
def test_a_double_press_sends_one_command(portal, visitor, robot, name):
    user = portal.person("ada", robot)
    portal.drive(user, robot)
    page = session(visitor(), user).page
    page.goto(portal.robots[robot].get_absolute_url())
    button = page.locator(f"[data-command={name}]").first
    expect(button).not_to_have_attribute("aria-disabled", "true")
    expect(page.locator("#robot.operating")).to_be_attached()
    expect(page.locator("#why")).not_to_contain_text("not known")
    button.evaluate(TWICE)
    expect(page.locator("#notice")).to_contain_text("One command at a time")
    expect(page.locator("#ladder li")).to_have_count(1)
    wait_for(lambda: page.wait_for_timeout(20) or portal.perform(), CEILING_S, "the command")
    expect(page.locator("#ladder li")).to_have_attribute("data-state", "completed")
    assert portal.robots[robot].commands.count() == 1
