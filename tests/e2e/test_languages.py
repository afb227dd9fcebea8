"""Every page in German and in the pseudo-language, which is longer and runs from right to left."""

import re

import pytest
from playwright.sync_api import expect

from operatorlog.models import Visibility
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.drawn import size
from tests.e2e.pages import OWN, PUBLIC, known, without
from tests.e2e.test_layout import OVER

ADMIN = ["/admin/", "/admin/robots/robot/", "/admin/operatorlog/entry/", "/survey/results/"]
# texts and named attributes that people see; not what is marked as data or as another language, nor code
TEXTS = """() => {
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT | NodeFilter.SHOW_ELEMENT);
  const data = 'script, style, noscript, code, kbd, pre, svg, [translate="no"], [lang]:not(html)';
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.nodeType === 1 ? node : node.parentElement;
    if (element.closest(data)) continue;
    const seen = element.checkVisibility({ contentVisibilityAuto: true, visibilityProperty: true });
    if (!seen) continue;
    if (node.nodeType === 3) found.push(node.data);
    else for (const name of ["title", "aria-label", "alt", "placeholder"]) found.push(element.getAttribute(name) ?? "");
  }
  return found.map((text) => text.trim()).filter((text) => text);
}"""
MARK = "\u202e"
SCROLLED = 'class="table-wrap" tabindex="0"'  # by keys, too: words of any length have room
WORD = re.compile(r"[A-Za-z]{3,}")
# names and words of robots, people and formats, which are the same in each language
NAMES = re.compile(
    r"\b(Farhand|Far|hand|English|Deutsch|Pseudo|Mercury|museum arm|iRat|PUMA|Hall rover|Virtual reality arm|min|UTC|JSON|CSV|MP4|WebM|MCAP|URDF|JPEG|GIF|QR"
    r"|ada|bob|cy|root|example\.org|Museum arm|Django)\b"
)

# what people wrote, addresses and the robot's own words; texts of Django that its Arabic catalogue lacks
DATA = ("wwww", "A burst of air left", "sim:", "READY", "True", "Search")


def unmarked(page):
    """Return the texts of a page that are in English, though the pseudo-language has been asked for."""
    texts = [text for text in page.evaluate(TEXTS) if MARK not in text and not any(data in text for data in DATA)]
    return [text for text in texts if WORD.search(NAMES.sub("", text))]


@pytest.fixture
def written(portal):
    cy = portal.person("cy", "mercury", "pa10")
    portal.entry(cy, "mercury", visibility=Visibility.FEATURED)
    return portal.entry(cy, "pa10", "w" * 300)


def addresses(entry):
    return without(known(PUBLIC, turn=entry.turn.pk), "irat", "rover", "puma", "embed")


def test_no_text_of_a_public_page_is_unmarked(portal, written, visitor):
    one = visitor(locale="ar-XB")
    found = {}
    for address in addresses(written):
        one.page.goto(address)
        expect(one.page.locator("html")).to_have_attribute("dir", "rtl")
        if one.page.locator("#state").count():
            expect(one.page.locator("#state")).not_to_be_empty()
        if texts := unmarked(one.page):
            found[address] = texts
    assert not found, "\n".join(f"{address}: {text!r}" for address, texts in found.items() for text in texts)


def test_no_text_of_a_persons_or_of_a_staff_page_is_unmarked(portal, written, visitor):
    one = session(visitor(locale="ar-XB"), portal.person("root", "mercury", is_staff=True, is_superuser=True))
    found = {}
    for address in [*addresses(written), *known(OWN, new="mercury").values(), *ADMIN]:
        one.page.goto(address)
        if texts := unmarked(one.page):
            found[address] = texts
    assert not found, "\n".join(f"{address}: {text!r}" for address, texts in found.items() for text in texts)


def test_longer_texts_from_right_to_left_stick_out_of_no_page(portal, written, visitor):
    one = visitor(locale="ar-XB")
    for address in addresses(written):
        one.page.goto(address)
        for wide in (390, 1440):
            size(one.page, wide, 900)
            assert [found for found in one.page.evaluate(OVER) if SCROLLED not in found] == [], (address, wide)


def test_the_switch_in_the_footer_changes_the_language_and_stays(portal, visitor):
    one = visitor()
    page = one.page
    page.goto("/story/")
    expect(page.locator("html")).to_have_attribute("lang", "en")
    page.locator(".languages").get_by_role("button", name="Deutsch").click()
    expect(page.locator("html")).to_have_attribute("lang", "de")
    assert page.url.endswith("/story/")
    page.goto("/robots/mercury/")
    expect(page.locator("html")).to_have_attribute("lang", "de")
    expect(page.locator("#state")).not_to_be_empty()
    assert page.evaluate("() => typeof texts.catalog") == "object"


@pytest.mark.parametrize("locale", ["en-US", "de-DE"])
def test_times_are_in_the_zone_of_the_browser_from_the_first_page_on(portal, written, visitor, locale):
    one = visitor(timezone_id="Asia/Kathmandu", locale=locale)
    page = one.page
    page.goto(written.turn.get_absolute_url())
    first = page.locator("time[data-moment]").first
    shown = first.inner_text()
    assert "UTC" not in shown
    page.reload()
    assert page.locator("time[data-moment]").first.inner_text() == shown, "the server writes what the script wrote"
    at = first.get_attribute("datetime")
    hour = page.evaluate("(at) => new Date(at).toLocaleTimeString('en-GB', { hour: '2-digit', minute: '2-digit' })", at)
    assert hour in shown
