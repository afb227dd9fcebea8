"""The operator's console over thin lines: it stays usable, and what it shows of the line and of the picture is true."""

import re
import time

import pytest
from playwright.sync_api import expect

from robots.kit.contract.command_packet import PING
from robots.models import Robot
from tests.conftest import at_length, wait_for
from tests.e2e.frames import read
from tests.e2e.thin_line import ThinLine
from tests.rig import free_port

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

# read as soon as the page has written its words once more: the times and the words are of the same moment
AGE = """() => new Promise((done) => {
  const age = document.querySelector("#age");
  new MutationObserver((_, observer) => {
    observer.disconnect();
    done([Number(document.querySelector("canvas[data-at]").dataset.at), Date.now(), age.innerText]);
  }).observe(age, { childList: true });
})"""
FEW_BYTES = "^(Very slow connection: only measured values|Slow connection: a new picture every 5 seconds)"
AT_MOST_1_KB = re.compile(r"^Line (good|fair|poor), (0\.\d|1\.[012])( of \d+(\.\d)?)? kB/s$")
LOADED_MS = 240_000
# bytes a second (0: no limit), round trip (s); what the page says of pictures and of the line, how old the picture on it
# is, how soon Stop arrives (s)
LINES = {
    "1 kB/s": (1000, 0.0, FEW_BYTES, AT_MOST_1_KB, "old", 3.0),
    "50 kB/s, 300 ms": (
        50_000, 0.3, "^(Slow connection: the pictures are coarse.)?$",
        re.compile(r"^Line (good|fair), (\d\.\d of )?([1-9]|[1-4]\d|\d\.\d) kB/s$"), "fresh", 1.5,
    ),
    "lossless": (0, 0.0, "^$", re.compile(r"^Line (good|fair), [\d. of]+ kB/s$"), "fresh", 1.0),
}  # fmt: skip


class Pings:
    """The round trips of a page, measured beside it."""

    def __init__(self, page):
        self._sent, self.took_ms = {}, []
        page.on("websocket", self._opened)

    def _opened(self, socket):
        socket.on("framesent", self._asked)
        socket.on("framereceived", self._answered)

    def _asked(self, data):
        if isinstance(data, bytes):
            if data[0] == PING:
                self._sent[int.from_bytes(data[1:], "big")] = time.monotonic()
        elif (said := read(data)).get("t") == "ping":
            self._sent[said["n"]] = time.monotonic()

    def _answered(self, data):
        if (said := read(data)).get("t") == "pong" and said["n"] in self._sent:
            self.took_ms.append((time.monotonic() - self._sent[said["n"]]) * 1000)


@pytest.fixture
def operator(portal, visitor):
    """A person who drives behind a line that is still good: (visitor, line, pings)."""
    line = ThinLine(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port))
    ada = visitor().cleared("ada", address=None)
    ada.allowed = ("ERR_", "WebSocket")
    pings = Pings(ada.page)
    ada.page.goto(f"http://localhost:{line.at[1]}/robots/mercury/")
    ada.take_turn()
    expect(ada.page.locator("#age")).to_have_text(re.compile("a second"))
    yield ada, line, pings
    line.set("cut")
    line.close()


def told_age_is_true(page, looks):
    """Compare the age that the page shows with the time that the picture on it bears; the clocks are the same here."""
    expect(page.locator("#age")).to_have_attribute("data-age", looks, timeout=20_000)
    taken, now, said = page.evaluate(AGE)
    found = re.match(r"Picture ([\d.]+) (s|min) old", said)
    assert found, said
    told = float(found[1]) * {"s": 1, "min": 60}[found[2]]
    assert told == pytest.approx((now - taken) / 1000, abs=0.8 if found[2] == "s" else 31), (said, now - taken)


def told_latency_is_true(page, pings, least_ms):
    """Compare the round trip that the page shows with one of the newest two that were measured beside it."""
    before = len(pings.took_ms)
    wait_for(lambda: page.wait_for_timeout(50) or len(pings.took_ms) > before, 60, "an answer")
    page.wait_for_timeout(400)  # it is drawn four times a second
    told = int(page.inner_text("#latency").removesuffix(" ms"))
    assert least_ms <= told
    assert any(told == pytest.approx(took, abs=200) for took in pings.took_ms[-2:]), (told, pings.took_ms)


def drives_again(page):
    """Wait until commands work: video that was on its way as the line became thin has to come first."""
    expect(page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "false", timeout=60_000)


@pytest.mark.parametrize("name", [at_length("1 kB/s"), "50 kB/s, 300 ms", at_length("lossless")])
def test_over_a_thin_line_one_commands_and_stops_and_is_told_the_truth(operator, name):
    ada, line, pings = operator
    page, (bytes_s, round_trip_s, words, line_words, looks, stop_s) = ada.page, LINES[name]
    line.thin(bytes_s, round_trip_s)
    expect(page.locator("#pace-said")).to_have_text(re.compile(words), timeout=90_000)
    page.wait_for_timeout(3000)
    told_age_is_true(page, looks)
    expect(page.locator("#line-said")).to_have_text(line_words, timeout=30_000)
    drives_again(page)
    ada.press("down")
    told_age_is_true(page, looks)
    told_latency_is_true(page, pings, 1000 * round_trip_s)
    page.click("[data-command=stop]")
    wait_for(lambda: page.wait_for_timeout(10) or Robot.objects.get().stop_latched, stop_s, "the stop")
    expect(page.locator("#release")).to_be_visible(timeout=20_000)
    expect(page.locator("#stop-said")).to_have_text("The robot is stopped", timeout=20_000)
    expect(page.locator("#banner")).to_be_hidden()


def test_an_operator_who_connects_again_over_1_kb_a_second_drives_on(operator):
    ada, line, _ = operator
    line.set("cut")
    expect(ada.page.locator("#banner")).to_be_visible()
    line.set("pass", bytes_s=1000)
    expect(ada.page.locator("#banner")).to_be_hidden(timeout=60_000)
    expect(ada.page.locator("#pace-said")).to_have_text(re.compile(FEW_BYTES), timeout=90_000)
    told_age_is_true(ada.page, "old")
    drives_again(ada.page)
    ada.press("down")


def test_a_page_is_opened_over_1_kb_a_second(portal, visitor):
    """By somebody whose browser has the site's scripts; what was never there takes minutes."""
    line = ThinLine(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port))
    someone = visitor()
    page = someone.page
    someone.allowed = ("ERR_", "WebSocket")
    where = f"http://localhost:{line.at[1]}/robots/mercury/"
    page.goto(where)
    expect(page.locator("#age")).to_have_text(re.compile("a second"))
    page.goto("about:blank")
    line.thin(1000)
    page.goto(where, timeout=LOADED_MS)
    expect(page.locator("#pace-said")).to_have_text(re.compile(FEW_BYTES), timeout=LOADED_MS)
    expect(page.locator("#line-said")).to_have_text(AT_MOST_1_KB, timeout=30_000)
    expect(page.locator("#banner")).to_be_hidden(timeout=30_000)
    expect(page.locator("#state")).to_have_text("Ready")
    assert re.match("No picture yet$|Picture .* old", page.inner_text("#age"))
    expect(page.locator("#age")).not_to_have_attribute("data-age", "fresh")
    line.set("cut")
    line.close()
