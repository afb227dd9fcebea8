"""The Sound button: off until it is pressed, by key as by mouse; what is heard is what the arm does."""

import re
from datetime import timedelta

import pytest
from django.db import transaction
from playwright.sync_api import expect

from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.states import Cycle, GrantKind
from tests.conftest import wait_for
from tests.e2e.test_pace import STATE, Heard

pytestmark = pytest.mark.timed

SOUND = 5
NONE = re.compile("^$")


@pytest.fixture
def hearing(portal):
    """The portal; its robot has a microphone, and moves slowly: it is heard for several seconds."""
    Robot.objects.filter(pk=portal.robot.pk).update(microphone="sim:microphone", settings={"speed": 0.1})
    return portal


def loud(page):
    return page.eval_on_selector("#loudness", "meter => meter.value")


def sounds(page, heard, many, seconds=25):
    before = heard.count(SOUND)
    wait_for(lambda: page.wait_for_timeout(100) or heard.count(SOUND) >= before + many, seconds, "sound")


def test_a_person_listens_by_key_and_hears_the_arm_move(hearing, visitor):
    someone = visitor()
    page, heard = someone.page, Heard(someone.page)
    someone.cleared("dora")
    button, said = page.locator("#sound"), page.locator("#sound-said")
    expect(button).to_have_attribute("aria-pressed", "false")
    wait_for(lambda: page.wait_for_timeout(50) or heard.count(STATE) >= 10, 25, "what the page has asked for comes")
    assert heard.count(SOUND) == 0
    assert all("sound" not in wish for wish in heard.wishes())
    assert hearing.sim.status()["listeners"] == 0
    button.focus()
    page.keyboard.press("Enter")
    expect(button).to_have_attribute("aria-pressed", "true")
    sounds(page, heard, 20)
    expect(said).to_have_text(NONE)
    expect(page.locator("#loudness")).to_be_visible()
    wait_for(lambda: page.wait_for_timeout(50) or loud(page) > 0, 10, "the quiet room")
    quiet = loud(page)
    assert quiet < 0.4
    someone.axe("while somebody listens")
    now, robot = SYSTEM.now(), hearing.robot
    with transaction.atomic():  # operated by nobody, it would be put in order
        Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.OPERATING)
        services.start_grant(robot, GrantKind.TURN, now, someone.user, now + timedelta(seconds=60))
    services.issue(robot.slug, someone.user, "move", {"x": 0.2, "y": 0.53}, 1)
    wait_for(lambda: page.wait_for_timeout(50) or loud(page) > quiet + 0.2, 15, "the arm, which is heard")
    page.select_option("#pace", "stills")
    expect(said).to_have_text("No sound while so little is asked for.")
    assert "sound" not in heard.wishes()[-1]
    page.select_option("#pace", "live")  # a machine that is too busy would let the page ask for less
    sounds(page, heard, 5)
    button.focus()
    page.keyboard.press("Space")
    expect(button).to_have_attribute("aria-pressed", "false")
    wait_for(lambda: hearing.sim.status()["listeners"] == 0, 15, "nobody listens")
    page.reload()
    expect(button).to_have_attribute("aria-pressed", "false")
    assert all("sound" not in wish for wish in heard.wishes()[-1:])


def test_a_browser_that_cannot_says_so_and_a_page_that_nobody_sees_is_silent_meanwhile(hearing, visitor):
    someone = visitor()
    page = someone.page
    page.add_init_script("delete globalThis.AudioDecoder")
    page.goto("/robots/mercury/")
    button, said = page.locator("#sound"), page.locator("#sound-said")
    expect(said).to_have_text("This browser cannot play the robot's sound.")
    button.focus()
    page.keyboard.press("Enter")
    expect(button).to_have_attribute("aria-pressed", "false")
    expect(button).to_have_attribute("aria-disabled", "true")
    someone.axe("without a decoder")
    other = visitor()
    page, heard = other.page, Heard(other.page)
    page.add_init_script(
        "globalThis.seen = (yes) => { Object.defineProperty(document, 'hidden', { configurable: true, get: () => !yes });"
        " document.dispatchEvent(new Event('visibilitychange')); };"
    )
    page.goto("/robots/mercury/")
    button = page.locator("#sound")
    button.click()
    sounds(page, heard, 5)
    page.evaluate("seen(false)")
    wait_for(lambda: page.wait_for_timeout(50) or "sound" not in heard.wishes()[-1], 15, "no sound is asked for")
    page.evaluate("seen(true)")
    sounds(page, heard, 5)
    expect(button).to_have_attribute("aria-pressed", "true")


def test_a_robot_without_a_microphone_has_no_button(portal, visitor):
    someone = visitor()
    someone.page.goto("/robots/mercury/")
    expect(someone.page.locator("#age")).to_be_visible()
    expect(someone.page.locator("#sound")).to_have_count(0)
