"""Pictures that come as video and are decoded by the browser, and JPEG where that does not work."""

import re

import pytest
from playwright.sync_api import expect

from robots.kit.contract.video import unpack
from tests.conftest import at_length, wait_for
from tests.e2e.test_pace import PICTURE, Heard

pytestmark = pytest.mark.timed

VIDEO = 4
AGE = re.compile(r"^Picture \d+(\.\d+)? (m?s) old, [\d.]+ a second$")
# the camera's levels: how many there are and their mean; a picture that was never drawn is one level
LEVELS = """() => {
  const canvas = document.getElementById("picture");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const seen = new Set();
  let sum = 0;
  for (let i = 0; i < data.length; i += 4) { seen.add(data[i]); sum += data[i]; }
  return { levels: seen.size, mean: sum / (data.length / 4), width: canvas.width, height: canvas.height, at: Number(canvas.dataset.at), still: canvas.dataset.still };
}"""


class Filmed(Heard):
    """What came over a page's socket, with the packets of video."""

    def __init__(self, page):
        super().__init__(page)
        self.packets, self.sizes = [], {VIDEO: [], PICTURE: []}

    def _received(self, data):
        super()._received(data)
        if isinstance(data, bytes) and data[0] in self.sizes:
            self.sizes[data[0]].append(len(data))
        if isinstance(data, bytes) and data[0] == VIDEO:
            self.packets.append(unpack(data))


def test_live_pictures_come_as_video_and_the_browser_decodes_them(portal, visitor):
    someone = visitor()
    page, heard = someone.page, Filmed(someone.page)
    page.goto("/robots/mercury/")
    wait_for(lambda: page.wait_for_timeout(100) or len(heard.packets) >= 10, 20, "video")
    expect(page.locator("#age")).to_have_text(AGE)
    assert heard.packets[0].key
    before, jpegs = page.evaluate(LEVELS), heard.count(PICTURE)
    assert before["levels"] > 20
    assert (before["width"], before["height"]) == (192, 165)
    at = {packet.at_ms for packet in heard.packets}
    assert before["at"] in at | {packet.at_ms for packet in heard.packets}, (
        "the picture on screen is one of the video's"
    )
    packets = len(heard.packets)
    wait_for(lambda: page.wait_for_timeout(50) or len(heard.packets) >= packets + 12, 20, "more video")
    wait_for(lambda: page.evaluate(LEVELS)["at"] > before["at"], 5, "a newer picture on screen")
    assert heard.count(PICTURE) == jpegs, "no JPEG comes beside the video"


@pytest.mark.parametrize("decodes", [True, at_length(False)], ids=["video", "JPEG"])
def test_coarse_pictures_take_a_fraction_and_are_as_large(portal, visitor, decodes):
    someone = visitor()
    page, heard = someone.page, Filmed(someone.page)
    if not decodes:
        page.add_init_script("delete globalThis.VideoDecoder")
    kind = VIDEO if decodes else PICTURE
    page.goto("/robots/mercury/")
    wait_for(lambda: page.wait_for_timeout(100) or heard.count(kind) >= 4, 20, "pictures")

    def size(pace):
        """Return how large pictures are at a pace that is chosen; a busy machine would choose a lower one."""
        page.select_option("#pace", pace)
        page.wait_for_timeout(1000)
        heard.sizes[kind].clear()
        wait_for(lambda: page.wait_for_timeout(100) or len(heard.sizes[kind]) >= 16, 20, f"{pace} pictures")
        return sum(heard.sizes[kind]) / len(heard.sizes[kind])

    whole, coarse = size("live"), size("coarse")
    assert heard.wishes()[-1].get("coarse") is True
    assert ("video" in heard.wishes()[-1]) is decodes
    assert coarse < 0.5 * whole
    expect(page.locator("#age")).to_have_text(AGE)
    shown = page.evaluate(LEVELS)
    assert (shown["width"], shown["height"]) == (192, 165)
    assert shown["levels"] > 10


def test_a_tab_that_nobody_sees_decodes_nothing_and_goes_on_when_it_is_seen(portal, visitor):
    someone = visitor()
    page, heard = someone.page, Filmed(someone.page)
    page.add_init_script(
        "globalThis.decoded = 0; const decode = VideoDecoder.prototype.decode;"
        "VideoDecoder.prototype.decode = function (chunk) { decoded += 1; return decode.call(this, chunk); };"
        "globalThis.seen = (yes) => {"
        " Object.defineProperty(document, 'hidden', { configurable: true, get: () => !yes });"
        " document.dispatchEvent(new Event('visibilitychange')); };"
    )
    page.goto("/robots/mercury/")
    wait_for(lambda: page.wait_for_timeout(100) or len(heard.packets) >= 5, 20, "video")
    page.evaluate("seen(false)")
    before, packets = page.evaluate("decoded"), len(heard.packets)
    wait_for(
        lambda: page.wait_for_timeout(100) or len(heard.packets) >= packets + 6, 10, "packets that come all the same"
    )
    assert page.evaluate("decoded") == before
    page.evaluate("seen(true)")
    wait_for(lambda: page.wait_for_timeout(100) or page.evaluate("decoded") > before, 5, "pictures again")
    expect(page.locator("#age")).to_have_text(AGE)


def test_a_browser_without_a_decoder_gets_jpeg(portal, visitor):
    someone = visitor()
    page, heard = someone.page, Filmed(someone.page)
    page.add_init_script("delete globalThis.VideoDecoder")
    page.goto("/robots/mercury/")
    expect(page.locator("#age")).to_have_text(AGE)
    wait_for(lambda: page.wait_for_timeout(100) or heard.count(PICTURE) >= 8, 10, "JPEG pictures")
    assert heard.packets == []
    assert all("video" not in wish for wish in heard.wishes())


FAILS = {
    "that reports an error": "VideoDecoder.prototype.decode = function () { throw new TypeError('broken') }",
    "that gives nothing": "VideoDecoder.prototype.decode = function () {}",
}


@pytest.mark.parametrize("how", FAILS)
def test_a_decoder(portal, visitor, how):
    someone = visitor()
    page, heard = someone.page, Filmed(someone.page)
    page.add_init_script(FAILS[how])
    page.goto("/robots/mercury/")
    wait_for(lambda: heard.packets or page.wait_for_timeout(100), 20, "video")
    wait_for(lambda: page.wait_for_timeout(100) or "video" not in heard.wishes()[-1], 10, "the page gives up video")
    before = heard.count(PICTURE)
    wait_for(lambda: page.wait_for_timeout(100) or heard.count(PICTURE) >= before + 4, 10, "JPEG pictures")
    expect(page.locator("#age")).to_have_text(AGE)
