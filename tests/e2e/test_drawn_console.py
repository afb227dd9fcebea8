"""The console that is drawn from a spec: after a motion one goes back to the values of before."""

import pytest
from playwright.sync_api import expect

from robots import bus
from robots.models import Command
from tests.e2e.bare import BarePortal
from tests.e2e.conftest import Visitor, session
from tests.packaged import installed_from, without_console
from tests.rig import Web
from tests.waiting import CEILING_S, wait_for

START, MOVED = 0.3, 1.2  # rad


@pytest.fixture
def joints():
    return {"turntable": (START,)}


@pytest.fixture
def driver(transactional_db, redis_server, monkeypatch, tmp_path, chromium, joints):
    """Who drives the turntable, and its portal."""
    with installed_from(without_console(tmp_path / "bare"), monkeypatch):
        bus.connection().flushall()
        web = Web()
        portal = BarePortal(web, joints)
        user = portal.person("ada", "turntable")
        portal.drive(user, "turntable")
        one = session(Visitor(chromium, portal), user)
        one.page.goto(portal.robot.get_absolute_url())
        one.page.wait_for_selector(".operating")
        yield one, portal
        one.close()
        portal.stop()
        web.kill()


def given(page):
    """Wait for one command; return it."""
    wait_for(lambda: page.wait_for_timeout(50) or Command.objects.exists(), CEILING_S, "a command")
    return Command.objects.get()


def test_after_a_motion_one_goes_back_to_the_values_of_before(driver, joints):
    one, portal = driver
    page = one.page
    back, angle = page.locator("[data-command=go-back]"), page.locator("#turn-angle")
    expect(back).to_have_attribute(
        "data-why", "There is nothing to go back to: no move to a position has ended in this turn."
    )
    angle.fill(str(MOVED))
    angle.press("Enter")
    assert given(page).args == {"angle": MOVED}
    joints["turntable"] = (MOVED,)
    expect(page.locator("#readings")).to_contain_text("1.200")
    assert portal.perform()
    expect(back).to_have_attribute("aria-disabled", "false")
    Command.objects.all().delete()
    back.press("Enter")
    expect(angle).to_have_value(str(START))
    one.axe("the values before the motion")
    assert not Command.objects.exists(), "they are shown first"
    page.keyboard.press("Enter")
    assert given(page).args == {"angle": START}
    joints["turntable"] = (START,)
    assert portal.perform()
    Command.objects.all().delete()
    expect(page.locator("#readings")).to_contain_text("0.300")
    page.locator("form.plain-command button", has_text="Home").press("Enter")  # no spec says what it ends as
    assert given(page).kind == "home"
    joints["turntable"] = (0.0,)
    assert portal.perform()
    expect(page.locator("#readings")).to_contain_text("0.000")
    back.press("Enter")
    expect(angle).to_have_value(str(MOVED))
