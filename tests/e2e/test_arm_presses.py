"""A button of an arm's console that is pressed twice sends one command, also before the server has answered the first."""

import pytest
from playwright.sync_api import expect

from robots.kit.clock import SYSTEM
from robots.states import CommandState
from tests.e2e.conftest import session
from tests.e2e.test_stage import portal as portal
from tests.waiting import CEILING_S, wait_for
from workers.commands.rows import advance, finish

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


@pytest.mark.parametrize(
    ("robot", "mode", "lines"),
    [("pa10", "program", "j 10 25 75 0 80 0"), ("pa10", "task", "open"), ("puma", "task", "open")],
)
def test_what_is_said_of_a_program_is_what_its_command_does(portal, visitor, robot, mode, lines):
    user = portal.person("ada", robot)
    portal.drive(user, robot)
    page = session(visitor(), user).page
    page.goto(portal.robots[robot].get_absolute_url())
    page.click(f"#tab-{mode}")
    page.fill(f"#{mode}-text", lines)
    said, run = (
        page.locator(f"#{mode}-said"),
        page.locator({"program": "[data-command=run]"}.get(mode, "[data-command=run-task]")),
    )
    expect(said).to_contain_text("Checked")

    def sent():
        expect(run).not_to_have_attribute("aria-disabled", "true")
        run.click()
        expect(said).to_have_text("It is sent and has not begun yet.")
        queued = portal.robots[robot].commands.filter(state=CommandState.QUEUED)
        wait_for(lambda: page.wait_for_timeout(20) or queued.exists(), CEILING_S, "the command")
        return queued.get()

    finish(sent(), CommandState.REJECTED, SYSTEM.now(), "The robot is stopped.")
    expect(said).to_have_text("Refused. The robot is stopped.")
    command = sent()
    for state in (CommandState.ACCEPTED, CommandState.SENT, CommandState.ACKNOWLEDGED):
        advance(command, state, SYSTEM.now())
    expect(said).to_have_text("It runs.")
    finish(command, CommandState.CANCELLED, SYSTEM.now(), "The motion was stopped on its way.")
    expect(said).to_have_text("Stopped. The motion was stopped on its way.")
