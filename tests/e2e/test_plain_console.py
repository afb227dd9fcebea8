"""The console that draws itself: a robot from a package without one, driven in the browser by a stranger."""

import pytest
from playwright.sync_api import expect

from portal.keep.seeding import add_robot
from robots.models import Command, Lease
from tests.conftest import wait_for
from tests.e2e.small import SmallPortal
from tests.packaged import installed_from, without_console

pytestmark = pytest.mark.timed


@pytest.fixture
def portal(transactional_db, redis_server, monkeypatch, tmp_path):
    with installed_from(without_console(tmp_path / "bare"), monkeypatch):
        made = SmallPortal(add_robot("turntable"))
        yield made
        made.stop()


def test_a_stranger_drives_a_robot_that_nobody_drew_a_console_for(portal, visitor):
    ada = visitor(viewport={"width": 390, "height": 844}).sign_up("ada").get_cleared()
    page = ada.page
    ada.take_turn()
    turn = page.locator("form.plain-command", has=page.locator("#turn-angle"))
    expect(turn.locator("button")).to_have_attribute("aria-disabled", "false")
    expect(page.locator("#turn-angle")).to_have_attribute("placeholder", "-3 to 3")
    expect(page.locator("#screen")).to_contain_text("This robot has no camera")
    expect(page.locator("#screen")).not_to_contain_text("No picture")
    expect(page.locator("#picture")).to_be_hidden()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    ada.axe("plain")
    turn.locator("button").click()  # nothing is filled in
    expect(page.locator("#notice")).to_contain_text("Fill in angle first")
    assert not Command.objects.filter(kind="turn").exists()
    recent = page.locator("#recent")
    expect(recent.locator("button")).to_have_count(0)
    page.fill("#turn-angle", "1.5")
    page.press("#turn-angle", "Enter")
    expect(page.locator("#ladder li").first).to_have_attribute("data-state", "completed")
    expect(page.locator("#readings tbody tr").first).to_contain_text("1.500")
    assert Lease.objects.get(robot=portal.robot).state["joints"] == pytest.approx([1.5], abs=1e-6)
    page.fill("#turn-angle", "1.4")
    page.press("#turn-angle", "Enter")
    expect(page.locator("#readings tbody tr").first).to_contain_text("1.400")
    expect(recent.locator("button")).to_have_text(["Turn: angle 1.4 rad", "Turn: angle 1.5 rad"])
    recent.locator("button").nth(1).click()  # one press chooses what was sent before, and another one sends it
    expect(page.locator("#turn-angle")).to_have_value("1.5")
    assert Command.objects.filter(kind="turn").count() == 2
    page.keyboard.press("Enter")
    expect(recent.locator("button")).to_have_text(["Turn: angle 1.5 rad", "Turn: angle 1.4 rad"])
    expect(page.locator("#readings tbody tr").first).to_contain_text("1.500")
    expect(page.locator("#ladder li").first).to_have_attribute("data-state", "completed")
    page.fill("#turn-angle", "-3")
    page.press("#turn-angle", "Enter")
    wait_for(
        lambda: page.wait_for_timeout(20) or Command.objects.filter(kind="turn", state="acknowledged").exists(),
        10,
        "it turns",
    )
    page.wait_for_timeout(300)
    page.keyboard.press("Escape")
    expect(page.locator("#release")).to_be_visible()
    ada.ladder("cancelled")
    said = page.locator("#readings tbody td").first
    expect(said).not_to_have_text("1.500")
    expect(said).not_to_have_text("-3.000")
    page.goto(f"{portal.url}/")
    expect(page.locator("[data-live=turntable]")).to_contain_text("No camera")
