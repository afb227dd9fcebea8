"""A command that goes down with its connection is said to be lost, and blocks nothing."""

import re

import pytest
from playwright.sync_api import expect

from tests.e2e.frames import read

pytestmark = pytest.mark.timed


def test_a_command_that_went_down_with_its_socket_is_said_to_be_lost_and_the_turn_goes_on(portal, visitor):
    page = (ada := visitor().cleared("ada")).page
    ada.allowed = ("ERR_", "WebSocket")
    lost = []

    def swallow(socket):
        """Pass everything on, but for the first command: with it the connection ends."""
        server = socket.connect_to_server()

        def say(message):
            if not lost and read(message).get("t") == "command":
                lost.append(message)
                socket.close(code=1012)
                server.close()
            else:
                server.send(message)

        socket.on_message(say)

    page.click("[data-do=take]")
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))
    page.route_web_socket(re.compile("/ws/(robots|operators)/"), swallow)
    page.reload()
    down = page.locator("[data-command=down]")
    expect(down).to_have_attribute("aria-disabled", "false", timeout=20_000)
    down.click()
    first = page.locator("#ladder li").first
    expect(first).to_contain_text("did not arrive", timeout=20_000)
    assert len(lost) == 1
    expect(down).to_have_attribute("aria-disabled", "false", timeout=20_000)
    ada.press("down")
    assert portal.robot.grants.get(ended_at=None).commands.get().kind == "down", "the first one never came"
