"""The operator's console over thin lines: it stays usable, and what it shows of the line and of the picture is true."""

import json
import re
import time

import pytest
from playwright.sync_api import expect

from robots.models import Robot
from tests.conftest import at_length, wait_for
from tests.e2e.thin_line import ThinLine
from tests.rig import free_port

AGE = """() => [Number(document.querySelector('canvas[data-at]').dataset.at), Date.now(),
  document.querySelector('#age').innerText, document.querySelector('#age').dataset.age]"""
# bytes a second, round trip (s); what the page says of pictures, how old the one on it is, how soon Stop arrives (s)
LINES = {
    "1 kB/s": (1000, 0.0, "^Very slow connection: only measured values", {"old"}, 3.0),
    "50 kB/s, 300 ms": (50_000, 0.3, "^(Slow connection: the pictures are coarse.)?$", {"fresh"}, 1.5),
}


class Pings:
    """The round trips of a page, measured beside it."""

    def __init__(self, page):
        self._sent, self.took_ms = {}, []
        page.on("websocket", self._opened)

    def _opened(self, socket):
        socket.on("framesent", self._asked)
        socket.on("framereceived", self._answered)

    def _asked(self, data):
        if isinstance(data, str) and (said := json.loads(data))["t"] == "ping":
            self._sent[said["n"]] = time.monotonic()

    def _answered(self, data):
        if isinstance(data, str) and (said := json.loads(data))["t"] == "pong" and said["n"] in self._sent:
            self.took_ms.append((time.monotonic() - self._sent[said["n"]]) * 1000)


@pytest.fixture
def operator(portal, visitor):
    """A person who drives behind a line that is still good: (visitor, line, pings)."""
    line = ThinLine(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port))
    ada = visitor().cleared("ada", address=None)
    ada.allowed = ("ERR_", "WebSocket")
    pings = Pings(ada.page)
    ada.page.goto(f"http://localhost:{line.at[1]}/robots/mercury/")
    ada.page.click("[data-do=join]")
    ada.page.locator("[data-do=accept]").press("Enter", timeout=20_000)
    ada.page.wait_for_selector(".operating", timeout=20_000)
    expect(ada.page.locator("#age")).to_have_text(re.compile("a second"))
    yield ada, line, pings
    line.set("cut")
    line.close()


def told_age_is_true(page, looks):
    """Compare the age that the page shows with the time that the picture on it bears; the clocks are the same here."""
    taken, now, said, look = page.evaluate(AGE)
    found = re.match(r"Picture ([\d.]+) (s|min) old", said)
    assert found, said
    told = float(found[1]) * {"s": 1, "min": 60}[found[2]]
    assert told == pytest.approx((now - taken) / 1000, abs=0.8 if found[2] == "s" else 31), (said, now - taken)
    assert look in looks, said


def told_latency_is_true(page, pings, least_ms):
    """Compare the round trip that the page shows with one of the newest two that were measured beside it."""
    before = len(pings.took_ms)
    wait_for(lambda: page.wait_for_timeout(50) or len(pings.took_ms) > before, 60, "an answer")
    page.wait_for_timeout(400)  # it is drawn four times a second
    told = int(page.inner_text("#latency").removesuffix(" ms"))
    assert least_ms <= told
    assert any(told == pytest.approx(took, abs=200) for took in pings.took_ms[-2:]), (told, pings.took_ms)


@pytest.mark.parametrize("name", [at_length("1 kB/s"), "50 kB/s, 300 ms"])
def test_over_a_thin_line_one_commands_and_stops_and_is_told_the_truth(operator, name):
    ada, line, pings = operator
    page, (bytes_s, round_trip_s, words, looks, stop_s) = ada.page, LINES[name]
    line.thin(bytes_s, round_trip_s)
    expect(page.locator("#pace-said")).to_have_text(re.compile(words), timeout=90_000)
    page.wait_for_timeout(3000)
    told_age_is_true(page, looks)
    ada.press("down")
    told_age_is_true(page, looks)
    told_latency_is_true(page, pings, 1000 * round_trip_s)
    page.click("[data-command=stop]")
    wait_for(lambda: page.wait_for_timeout(10) or Robot.objects.get().stop_latched, stop_s, "the stop")
    expect(page.locator("#release")).to_be_visible(timeout=20_000)
    expect(page.locator("#stop-said")).to_have_text("The robot is stopped", timeout=20_000)
    expect(page.locator("#banner")).to_be_hidden()
