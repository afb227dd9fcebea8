"""A recording whose files cannot be read at first, and the code to copy on a narrow page."""

import pytest
from playwright.sync_api import expect

from tests.e2e.bare import portal as portal
from tests.e2e.recorded import recording as recording


@pytest.fixture
def one(visitor):
    made = visitor()
    made.allowed = ("503", "net::")
    return made


def fail(page, path):
    page.route(path, lambda route: route.fulfill(status=503, body=""))


def test_an_index_that_could_not_be_read_is_asked_for_again(portal, one, recording):
    page, said = one.page, one.page.locator("#replay-said")
    fail(page, "**/index.json")
    page.goto(recording.get_absolute_url())
    expect(said).to_contain_text("could not be read")
    expect(page.locator("#replay-play")).to_be_disabled()
    page.unroute("**/index.json")
    for control in ("play", "at", "speed"):
        expect(page.locator(f"#replay-{control}")).to_be_enabled(timeout=60_000)
    expect(said).to_be_empty()
    expect(page.locator("#replay-time")).to_contain_text("0:23")


def test_a_moment_that_is_read_leaves_no_words_of_one_that_was_not(portal, one, recording):
    page, said = one.page, one.page.locator("#replay-said")
    page.goto(recording.get_absolute_url())
    expect(page.locator("#replay-at")).to_be_enabled()
    expect(page.locator("#replay-time")).to_contain_text("0:23")
    fail(page, "**/*.bin")
    moments = page.locator("#replay-list button")
    moments.last.click()
    expect(said).to_contain_text("could not be read")
    page.unroute("**/*.bin")
    moments.first.click()
    expect(page.locator("#replay-time")).to_contain_text("0:05")
    expect(page.locator("#ladder li")).to_have_count(1)  # the moment is shown
    expect(said).to_be_empty()


def test_the_code_to_copy_stays_within_a_narrow_page(portal, one, recording):
    page = one.page
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto(recording.get_absolute_url())
    expect(page.locator("#replay-at")).to_be_enabled()
    page.evaluate("() => { navigator.clipboard.writeText = () => Promise.reject(new Error()); }")
    page.click("#replay-embed")
    expect(page.locator("#replay-said")).to_contain_text("<iframe")
    assert page.evaluate("document.documentElement.scrollWidth") == 390
