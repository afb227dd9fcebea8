"""The museum arm's page over a thin line: a motion is drawn as expected at once, and in bytes it is asked for."""

import re

import pytest
from playwright.sync_api import expect

from robots.models import Command
from tests.conftest import wait_for
from tests.e2e.thin_line import ThinLine
from tests.rig import free_port

pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["pa10"], indirect=True)]

BYTES_S = 200
MOST = 24  # bytes of a command of an arm


def test_a_motion_is_shown_as_expected_until_states_confirm_it(transactional_db, portal, visitor):
    line = ThinLine(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port))
    ada = visitor().cleared("ada", address=None)
    ada.allowed = ("ERR_", "WebSocket")
    page, asked = ada.page, []

    def opened(socket):
        socket.on("framesent", lambda data: asked.append(data) if isinstance(data, bytes) else None)

    page.on("websocket", opened)
    page.goto(f"http://localhost:{line.at[1]}/robots/pa10/")
    ada.take_turn()
    expect(page.locator("#model canvas")).to_be_visible(timeout=60_000)
    page.select_option("#pace", "states")
    page.click("#tab-joint")
    expect(page.locator("#model-said")).to_have_text("The arm is there", timeout=20_000)
    page.fill("#speed", "10")
    page.fill(".joint:nth-child(1) input[type=number]", "60")
    expect(page.locator("#model-said")).to_contain_text("s on the way", timeout=60_000)
    line.thin(BYTES_S)  # not earlier: a preview has thousands of bytes
    assert page.locator("#model[data-expected]").count() == 0
    ada.give("go-joints")
    expect(page.locator("#model")).to_have_attribute("data-expected", "", timeout=20_000)
    assert portal.sim.status()["moving"], "it is shown while the arm moves"
    (packed,) = [data for data in asked if data[:1] == b"\x08"]
    assert len(packed) <= MOST
    wait_for(lambda: page.wait_for_timeout(100) or not portal.sim.status()["moving"], 60, "the end of the motion")
    expect(page.locator("#model")).not_to_have_attribute("data-expected", re.compile(""), timeout=30_000)
    wait_for(lambda: Command.objects.get(kind="joints").state == "completed", 30, "the command")
    assert portal.sim.status()["q"][0] == pytest.approx(1.0472, abs=0.01)
    line.set("cut")
    line.close()
