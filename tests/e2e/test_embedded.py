"""What other sites show in a frame, and what one copies for them."""

import re
from datetime import timedelta

import pytest
from playwright.sync_api import expect

from tests.e2e.bare import portal as portal
from tests.e2e.recorded import SECONDS, jpeg
from tests.e2e.recorded import recording as recording


@pytest.fixture(autouse=True)
def as_long_as_its_pictures(recording):
    recording.ended_at = recording.began_at + timedelta(seconds=SECONDS - 1)
    recording.save()


def test_a_recording_in_a_frame_is_played_stopped_and_moved_in_time(portal, visitor, recording):
    page = visitor().page
    page.goto(f"/embed/recordings/{recording.key}/?t=5")
    play, bar, picture = (page.locator(selector) for selector in ("#play", "#at", "#picture"))
    expect(picture).to_have_attribute("src", re.compile(r"-5\.jpg$"))
    expect(bar).to_have_value("5")
    play.click()
    expect(play).to_have_text("Pause")
    expect(bar).not_to_have_value("5")
    play.click()
    expect(play).to_have_text("Play")
    bar.press("End")
    last = bar.get_attribute("max")
    expect(picture).to_have_attribute("src", re.compile(rf"-{last}\.jpg$"))
    expect(bar).to_have_attribute("aria-valuetext", f"0:{int(last):02}")
    play.click()  # at its end it begins again
    expect(play).to_have_text("Pause")
    expect(bar).not_to_have_value(last)


def test_a_robot_in_a_frame_shows_newer_pictures(portal, visitor):
    page = visitor().page
    page.route("**/camera/0.jpg*", lambda route: route.fulfill(content_type="image/jpeg", body=jpeg(100)))
    page.goto("/embed/robots/mercury/")
    expect(page.locator("#picture")).to_have_attribute("src", re.compile(r"\?\d+$"))


@pytest.mark.parametrize("granted", [True, False])
def test_a_link_and_the_code_of_a_frame_are_copied_or_shown(portal, visitor, recording, granted):
    one = visitor()
    one.context.grant_permissions(["clipboard-read", "clipboard-write"] if granted else [])
    page = one.page
    page.goto(f"{recording.get_absolute_url()}?t=6")
    expect(page.locator("#replay-time")).to_contain_text("0:06")
    for button, said, copied in (
        ("#replay-share", "The link was copied.", rf"{recording.get_absolute_url()}\?t=6$"),
        (
            "#replay-embed",
            "The code was copied.",
            rf'<iframe src="[^"]*/embed/recordings/{recording.key}/\?t=6" title="',
        ),
    ):
        page.locator(button).click()
        if granted:
            expect(page.locator("main")).to_contain_text(said)
            assert re.search(copied, page.evaluate("navigator.clipboard.readText()"))
        else:
            expect(page.locator("main")).to_contain_text("Your browser did not let the page copy it")
            expect(page.locator("main")).to_contain_text("?t=6")
