"""Cheers on the pages of who watches and of who drives: nothing moves, and whoever drives can hide them."""

from playwright.sync_api import expect

from tests.e2e.bare import portal as portal
from tests.e2e.drawn import settle
from tests.e2e.test_steady import SIZES, press, still
from tests.e2e.test_steady import watching as watching


@SIZES
def test_cheers_move_nothing_and_whoever_drives_can_hide_them(watching, portal, visitor, size):
    one = watching("mercury", size)
    viewport = dict(zip(("width", "height"), size, strict=True))
    watcher = visitor(viewport=viewport)
    watcher.page.goto(portal.robots["mercury"].get_absolute_url())
    button = watcher.page.locator("#cheer")
    expect(button).to_have_attribute("aria-disabled", "false")
    expect(watcher.page.locator("#line-said")).not_to_be_empty(timeout=20_000)
    button.scroll_into_view_if_needed()
    settle(watcher.page)
    with still(one), still(watcher):
        press(watcher.page, button)
        expect(watcher.page.locator("#cheer-said")).to_have_text("You cheered.")
        for page in (watcher.page, one.page):
            expect(page.locator("#cheers")).to_have_text(", 1 cheer", timeout=10_000)
            expect(page.locator("#cheers-heard")).to_have_text("1 cheer.")
    expect(button).to_have_attribute("aria-disabled", "false", timeout=10_000)
    watcher.axe("who cheers")
    one.page.locator("#cheers-choice").scroll_into_view_if_needed()
    settle(one.page)
    with still(one):
        press(one.page, one.page.locator("#cheers-choice"))
        expect(one.page.locator("#cheers")).to_be_empty()
    one.axe("no cheers")
    one.page.reload()
    expect(one.page.locator("#cheers-shown")).not_to_be_checked()
    expect(one.page.locator("#cheers-choice")).to_be_visible()
    expect(one.page.locator("#cheers")).to_be_empty()
