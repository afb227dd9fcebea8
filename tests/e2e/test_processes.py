"""A page whose web process dies goes on with another one by itself, and its operator keeps the turn."""

import re

import pytest
from playwright.sync_api import expect

from robots.models import Command
from tests.conftest import wait_for
from tests.faults.proxy import Proxy
from tests.rig import Web, free_port

pytestmark = pytest.mark.timed


def test_a_page_whose_web_process_is_killed_goes_on_with_another(portal, visitor):
    webs = [Web(), Web()]
    proxy = Proxy(("127.0.0.1", free_port()), ("127.0.0.1", webs[0].port))
    try:
        ada = visitor().cleared("ada", None)
        # the process that is killed may hold the lock of a count: for a moment the page gets no code, and asks again
        ada.allowed = ("WebSocket connection to", "ERR_", "status of 429")
        page = ada.page
        page.goto(f"http://localhost:{proxy.at[1]}/robots/mercury/")
        page.click("[data-do=take]")
        expect(page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "false")
        webs[0].kill()
        expect(page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "true")
        proxy.to = ("127.0.0.1", webs[1].port)
        expect(page.locator("#age")).to_have_text(re.compile(r"^Picture [01]\.\d s old"), timeout=30_000)
        expect(page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "false", timeout=30_000)
        ada.press("down")
        assert wait_for(lambda: Command.objects.filter(kind="down", state="completed").first(), 20, "the motion")
    finally:
        proxy.close()
        for web in webs:
            web.kill()
