"""The panel of a person's place: a press counts however long it lasts, and the focus stays."""

import re

from playwright.sync_api import expect

from queueing.models import Turn

COUNT = """
() => { window.presses = 0;
  document.addEventListener("click", (event) => {
    if (!event.target.closest("#place [data-do=leave]")) return;
    window.presses += 1;
    event.stopImmediatePropagation();
  }, true); }
"""
PRESSES = 20


# what comes and goes above the panel, as when a busy machine's robot is silent for a moment, moves it from under a press
QUIET = "() => { document.getElementById('banner').style.display = 'none'; }"


def press(page, button, seconds):
    """Press as a slow hand does: down, wait, up."""
    box = button.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.wait_for_timeout(seconds * 1000)
    page.mouse.up()


def test_presses_across_ticks_all_count(portal, visitor):
    ada = visitor().cleared("ada")
    page = ada.page
    page.click("[data-do=join]")
    take = page.locator("[data-do=accept]")
    expect(take).to_be_visible()
    page.evaluate(QUIET)
    press(page, take, 1.1)
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))

    page.evaluate(COUNT)
    end = page.locator("#place [data-do=leave]")
    end.scroll_into_view_if_needed()
    for i in range(PRESSES):
        press(page, end, 0.05 + 0.25 * (i % 3))
    assert page.evaluate("presses") == PRESSES
    assert Turn.objects.filter(ended_at=None).count() == 1


def test_the_focus_stays_on_the_same_button_over_ticks(portal, visitor):
    ada = visitor().cleared("ada")
    page = ada.page
    page.click("[data-do=join]")
    page.locator("[data-do=accept]").press("Enter")
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))
    page.wait_for_timeout(500)  # the screen takes the focus as the turn begins
    page.evaluate("() => { window.lost = 0; window.kept = document.querySelector('#place [data-do=leave]');"
                  " kept.focus(); kept.addEventListener('blur', () => window.lost++); }")  # fmt: skip
    for _ in range(3):  # ticks
        before = page.inner_text("#place [role=timer]")
        expect(page.locator("#place [role=timer]")).not_to_have_text(before)
    assert page.evaluate("document.activeElement === kept && kept.isConnected")
    assert page.evaluate("lost") == 0
