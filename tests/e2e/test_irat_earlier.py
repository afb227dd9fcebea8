"""The iRat's map is cleared: the page says why and when, and the earlier map can still be looked at."""

import re

import pytest
from playwright.sync_api import expect

from robots.kit.drivers.irat.packets import Why
from tests.e2e.roaming import MAP, place_on
from tests.e2e.roaming import portal as portal
from tests.e2e.test_axe import DARK, LIGHT

pytestmark = pytest.mark.timed

PAINTED = """() => { const c = document.getElementById('map'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
  let n = 0; for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return n; }"""

OTHER = "() => Math.abs(({})() / {} - 1) > 0.05"


@pytest.mark.parametrize("look", [LIGHT, DARK])
def test_a_cleared_map_is_told_of_and_can_be_shown(portal, visitor, look):
    one = visitor(**look)
    page = one.page
    page.goto("/robots/irat/")
    expect(page.locator("#spots button").first).to_have_attribute("aria-disabled", "false", timeout=30_000)
    expect(page.locator("#earlier")).to_be_hidden()
    page.wait_for_function(f"() => ({PAINTED})() > 500")
    whole = page.evaluate(PAINTED)
    below = page.locator("#asking").bounding_box()
    portal.clear(Why.AGE)
    words = re.compile(
        f"^Map {MAP} ended at .*, because it was 11 minutes old and nobody's goal waited; a new map was begun"
    )
    expect(page.locator("#notice")).to_have_text(words)
    expect(page.locator("#earlier-said")).to_have_text(words)
    assert page.locator("#asking").bounding_box()["y"] == below["y"], "nothing below the map is pushed down"
    page.wait_for_function(OTHER.format(PAINTED, whole))
    new = page.evaluate(PAINTED)
    button = page.get_by_role("button", name="Show the earlier map")
    assert button.bounding_box()["height"] >= 44
    button.focus()
    page.keyboard.press("Enter")
    button = page.get_by_role("button", name="Show the map of now")
    expect(button).to_be_focused()
    expect(page.locator("#map-how")).to_be_hidden()
    expect(page.locator("#map-said")).to_have_text(f"Earlier map, number {MAP}")
    page.wait_for_function(OTHER.format(PAINTED, new))
    page.locator("#map").click(position=place_on(page, 15))
    expect(page.locator("#notice")).to_contain_text("This is an earlier map")
    expect(page.locator("#notice")).to_contain_text("Show the map of now")
    one.axe("earlier map")
    assert page.evaluate("document.documentElement.scrollWidth") <= page.viewport_size["width"]
    page.locator("#earlier-show").press("Space")
    expect(page.get_by_role("button", name="Show the earlier map")).to_be_focused()
    expect(page.locator("#notice")).to_be_hidden(timeout=4000)
    expect(page.locator("#map-how")).to_be_visible()
    page.wait_for_function(f"() => !({OTHER.format(PAINTED, new)})()")
    late = visitor(**look)
    late.page.goto("/robots/irat/")
    expect(late.page.locator("#earlier-said")).to_have_text(words, timeout=30_000)
    expect(late.page.locator("#notice")).to_be_hidden()
    page.locator("#earlier-show").press("Space")
    page.locator("#spots button").first.click()
    expect(page.locator("#asked")).to_contain_text("Your goal", timeout=8000)  # the list is of the map of now
