"""Without a connection the page says so as long as it is true, and what happened to a Stop."""

import re

import pytest
from playwright.sync_api import expect

from queueing.models import Turn
from robots.models import Robot
from tests.conftest import wait_for
from tests.e2e.frames import read
from tests.faults.proxy import Proxy
from tests.rig import free_port

pytestmark = pytest.mark.timed

DESKTOP, PHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
BLAME = re.compile("robot does not answer|state is not known")


@pytest.fixture
def bench(portal, visitor):
    """A page behind a line that can be cut: (visitor, line)."""
    line = Proxy(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port))
    ada = visitor().cleared("ada")
    ada.allowed = ("ERR_", "WebSocket")
    yield ada, line
    line.set("cut")
    line.close()


class Frames:
    """What a page says over its sockets to robots, and which of its pings are answered."""

    def __init__(self, page):
        self.sent, self._pongs = [], set()
        page.on("websocket", self._opened)

    def _opened(self, socket):
        if "/ws/robots/" in socket.url:
            socket.on("framesent", lambda data: self.sent.append(read(data)))
            socket.on("framereceived", self._heard)

    def _heard(self, data):
        if (said := read(data)).get("t") == "pong":
            self._pongs.add(said["n"])

    def answered(self, page):
        """Wait until the portal has answered a ping of now: what the page has said before has arrived."""
        last = max((said["n"] for said in self.sent if said.get("t") == "ping"), default=0)
        page.evaluate("dispatchEvent(new Event('online'))")  # a page that hears of a network asks at once
        wait_for(lambda: page.wait_for_timeout(20) or any(n > last for n in self._pongs), 20, "an answer")


def operate(ada, line, size):
    page = ada.page
    page.set_viewport_size(size)
    page.goto(f"http://localhost:{line.at[1]}/robots/mercury/")
    page.click("[data-do=take]")
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))
    expect(page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "false")
    return page


def back(ada, line):
    """Have the connection back. The line comes first: a page that hears of a network tries once, at once."""
    line.set("pass")
    ada.context.set_offline(False)


def watch_banner(page, seconds):
    """Read the banner every tenth of a second."""
    said = set()
    for _ in range(int(seconds * 10)):
        said.add(page.inner_text("#banner") if page.is_visible("#banner") else "")
        page.wait_for_timeout(100)
    return said


@pytest.mark.parametrize(
    ("way", "size"),
    [
        pytest.param("cut", DESKTOP, id="desktop-cut"),
        pytest.param("stall", PHONE, id="phone-stall", marks=pytest.mark.length),
        pytest.param("stall", DESKTOP, id="desktop-stall", marks=pytest.mark.length),
        pytest.param("cut", PHONE, id="phone-cut", marks=pytest.mark.length),
    ],
)
def test_a_lost_connection_is_said_for_as_long_as_it_lasts_and_blames_no_robot(bench, size, way):
    ada, line = bench
    page = operate(ada, line, size)
    ada.context.set_offline(True)
    line.set(way)
    expect(page.locator("#banner")).to_contain_text("Connection lost")
    assert page.is_visible("#banner")
    said = watch_banner(page, 10)
    assert all(words.startswith("Connection lost") for words in said), said
    assert not any(BLAME.search(words) for words in said)
    expect(page.locator("#why")).to_contain_text("connection is lost")
    ada.axe("offline")
    line.set("cut")
    back(ada, line)
    expect(page.locator("#banner")).to_be_hidden(timeout=20_000)


@pytest.mark.parametrize("size", [pytest.param(DESKTOP, marks=pytest.mark.length), PHONE], ids=["desktop", "phone"])
def test_a_stop_pressed_offline_says_what_happens_and_is_sent_when_the_line_is_back(portal, bench, size):
    ada, line = bench
    page = operate(ada, line, size)
    line.set("cut")
    ada.context.set_offline(True)
    expect(page.locator("#banner")).to_contain_text("Connection lost")
    page.click("[data-command=stop]")
    expect(page.locator("#banner")).to_contain_text("Stop could not be sent")
    expect(page.locator("#banner")).to_contain_text("within half a second")
    tried = []
    page.on("websocket", lambda socket: tried.append(socket.url))
    wait_for(lambda: page.wait_for_timeout(20) or len(tried) >= 2, 30, "two more tries to connect, in vain")
    page.wait_for_timeout(1600)  # a Stop that is answered within 1.5 s is not late
    assert "Stop could not be sent" in page.inner_text("#banner")
    assert not Robot.objects.get().stop_latched
    back(ada, line)
    wait_for(lambda: page.wait_for_timeout(10) or Robot.objects.get().stop_latched, 15, "the late stop")
    expect(page.locator("#notice")).to_contain_text("has been sent now")
    expect(page.locator("#release")).to_be_visible()
    expect(page.locator("#banner")).to_be_hidden()


def test_a_late_stop_does_not_stop_the_next_persons_turn(portal, bench):
    ada, line = bench
    frames = Frames(ada.page)
    page = operate(ada, line, DESKTOP)
    line.set("cut")
    ada.context.set_offline(True)
    expect(page.locator("#banner")).to_contain_text("Connection lost")
    page.keyboard.press("Escape")
    page.locator("#screen").press("Escape")
    expect(page.locator("#banner")).to_contain_text("Stop could not be sent")
    wait_for(
        lambda: page.wait_for_timeout(100) or Turn.objects.filter(ended_at=None).count() == 0, 40, "the turn's end"
    )
    before = len(frames.sent)
    back(ada, line)
    expect(page.locator("#notice")).to_contain_text("was not sent", timeout=20_000)
    frames.answered(page)
    assert "stop" not in [said.get("t") for said in frames.sent[before:]]
    assert not Robot.objects.get().stop_latched
