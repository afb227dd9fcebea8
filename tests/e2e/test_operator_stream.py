"""An operator has a stream of their own, opened with a one-time code: another after a reload, none after the turn."""

import re

import pytest
from playwright.sync_api import expect

from queueing.models import Turn
from queueing.services import end_turn
from robots.kit.clock import SYSTEM
from robots.states import GrantEnd
from tests.conftest import wait_for

pytestmark = pytest.mark.timed

PICTURES = (2, 4)  # as JPEG, as video
FRESH = re.compile(r"old, [\d.]+ a second")


class Sockets:
    """The sockets and codes of a page."""

    def __init__(self, page):
        self.page, self.codes, self.opened = page, [], []
        page.on("response", self._answered)
        page.on("websocket", self._opened)

    def _answered(self, response):
        if response.url.endswith("/stream-code/") and response.ok:
            self.codes.append(response)

    def _opened(self, socket):
        if "/ws/me/" in socket.url:
            return
        one = {"own": "/ws/operators/" in socket.url, "open": True, "pictures": 0, "sent": []}
        self.opened.append(one)
        socket.on("close", lambda _: one.update(open=False))
        socket.on("framereceived", lambda data: one.update(pictures=one["pictures"] + _pictured(data)))
        socket.on("framesent", lambda data: one["sent"].append(data))

    def open(self):
        return [one for one in self.opened if one["open"]]

    def wait(self, own):
        """Wait until the page has one socket alone, of its own or everybody's, over which pictures come; return it."""

        def there():
            self.page.wait_for_timeout(100)
            found = self.open()
            return len(found) == 1 and found[0]["own"] == own and found[0]["pictures"] and found[0]

        found = wait_for(there, 40, f"one socket ({self.opened})")
        before = found["pictures"]
        wait_for(lambda: self.page.wait_for_timeout(100) or found["pictures"] > before + 2, 10, "more pictures")
        return found


def _pictured(data):
    return isinstance(data, bytes) and data[0] in PICTURES


def test_a_reload_of_the_operators_page_gets_another_code_and_pictures_go_on(portal, visitor):
    ada = visitor().cleared("ada", address=None)
    page = ada.page
    page.on("dialog", lambda dialog: dialog.accept())  # whether one wants to leave in one's turn
    sockets = Sockets(page)
    page.goto("/robots/mercury/")
    sockets.wait(own=False)
    assert not sockets.codes
    ada.take_turn()
    first = sockets.wait(own=True)
    assert len(sockets.codes) == 1
    before = sockets.codes[0].json()["code"]
    ada.press("down")
    assert any('"command"' in said for said in first["sent"]), "commands go over the stream of one's own"
    assert Turn.objects.get().connected
    sockets.opened.clear()
    page.reload()
    sockets.wait(own=True)
    assert [code.json()["code"] != before for code in sockets.codes[1:]] == [True]
    expect(page.locator("#age")).to_have_text(FRESH)
    assert Turn.objects.get().connected

    end_turn(Turn.objects.get(), GrantEnd.TIME_UP, "time is up", SYSTEM.now())
    expect(page.locator("#notice")).to_contain_text("Your turn is over")
    sockets.wait(own=False)
    expect(page.locator("#banner")).to_be_hidden()
    expect(page.locator("#age")).to_have_text(FRESH)
    assert len(sockets.codes) == 2
