"""How much a page asks for: what its person chose, or what the line can carry."""

import json
import re
from urllib.parse import parse_qs, urlsplit

import pytest
from playwright.sync_api import expect

from tests.conftest import wait_for
from tests.e2e.frames import read
from tests.faults.proxy import Proxy
from tests.rig import free_port

pytestmark = pytest.mark.timed

COMPACT, STATE, PICTURE = 128, 1, 2
SLOW = 6000  # bytes a second


class Heard:
    """The messages that came over a page's socket, and what the page has asked for."""

    def __init__(self, page):
        self.kinds, self.asked = [], []
        page.on("websocket", self._opened)

    def _opened(self, socket):
        if "/ws/robots/" not in socket.url:
            return
        self.asked.append(json.loads(parse_qs(urlsplit(socket.url).query)["watch"][0]))
        socket.on("framereceived", self._received)
        socket.on("framesent", lambda data: self.asked.append(read(data)))

    def _received(self, data):
        if isinstance(data, bytes):
            self.kinds.append(COMPACT if data[0] >= COMPACT else data[0])

    def wishes(self):
        return [said for said in self.asked if said.get("t") == "watch"]

    def count(self, kind):
        return self.kinds.count(kind)


def test_a_person_chooses_how_much_comes_and_the_page_remembers(portal, visitor):
    someone = visitor()
    page, heard = someone.page, Heard(someone.page)
    page.goto("/robots/mercury/")
    expect(page.locator("#age")).to_have_text(re.compile(r"old, [\d.]+ a second"))
    expect(page.locator("#pace")).to_have_value("auto")
    page.select_option("#pace", "states")
    wait_for(lambda: page.wait_for_timeout(100) or heard.count(COMPACT) >= 3, 10, "compact states")
    before, states = heard.count(PICTURE), heard.count(COMPACT)
    wait_for(lambda: page.wait_for_timeout(50) or heard.count(COMPACT) >= states + 6, 20, "states of 1.5 s")
    assert heard.count(PICTURE) <= before + 1
    assert heard.wishes()[-1] == {"t": "watch", "cameras": [], "every_s": 0, "compact": True, "pieces": True}
    page.reload()
    expect(page.locator("#pace")).to_have_value("states")
    wait_for(lambda: page.wait_for_timeout(100) or heard.wishes()[-1]["cameras"] == [], 10, "the same wish")
    page.select_option("#pace", "stills")
    before = heard.count(PICTURE)
    page.wait_for_timeout(6000)
    assert 1 <= heard.count(PICTURE) - before <= 3
    page.select_option("#pace", "live")
    expect(page.locator("#age")).to_have_text(re.compile(r"old, [\d.]+ a second"))


@pytest.mark.parametrize("back", [True, False], ids=["and back", "there"])
def test_a_slow_line_gets_a_picture_now_and_then_and_a_good_one_live_pictures_again(portal, visitor, back):
    line = Proxy(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port), buffer=8192)
    someone = visitor()
    someone.allowed = ("ERR_", "WebSocket")
    page, heard = someone.page, Heard(someone.page)
    page.goto(f"http://localhost:{line.at[1]}/robots/mercury/")
    expect(page.locator("#age")).to_have_text(re.compile("a second"))
    line.set("slow", bytes_s=SLOW)
    expect(page.locator("#pace-said")).to_have_text(re.compile("^(Slow|Very slow) connection"), timeout=30_000)
    wait_for(lambda: page.wait_for_timeout(100) or heard.count(COMPACT) >= 3, 30, "compact states")
    expect(page.locator("#banner")).to_be_hidden()
    if back:
        line.set("pass")
        expect(page.locator("#pace-said")).to_have_text("", timeout=120_000)
        expect(page.locator("#age")).to_have_text(re.compile("a second"), timeout=20_000)
    line.set("cut")
    line.close()


def test_everybody_sees_how_many_watch(portal, visitor):
    first, second = visitor(), visitor()
    first.page.goto("/robots/mercury/")
    expect(first.page.locator("#watchers")).to_have_text(", only you watch")
    second.page.goto("/robots/mercury/")
    for one in (first, second):
        expect(one.page.locator("#watchers")).to_have_text(", you and 1 other watch")
    second.page.close()
    expect(first.page.locator("#watchers")).to_have_text(", only you watch")


def test_who_drives_does_not_watch_and_a_person_with_two_pages_is_one(portal, visitor):
    ada, bob = visitor().cleared("ada"), visitor().cleared("bob", None)
    ada.page.click("[data-do=take]")
    expect(ada.page.locator("#watchers")).to_have_text(", nobody else watches")
    again = ada.new_page()
    again.goto("/robots/mercury/")
    expect(again.locator("#watchers")).to_have_text(", nobody else watches")
    for page in (bob.page, bob.new_page()):
        page.goto("/robots/mercury/")
        expect(page.locator("#watchers")).to_have_text(", only you watch")
    expect(ada.page.locator("#watchers")).to_have_text(", 1 other watches")
    visitor().page.goto("/robots/mercury/")
    expect(bob.page.locator("#watchers")).to_have_text(", you and 1 other watch")
    expect(ada.page.locator("#watchers")).to_have_text(", 2 others watch")
