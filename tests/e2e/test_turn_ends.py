"""How turns end, in a browser: idleness is said before, and every page says why a turn ended."""

import re
from datetime import timedelta

import pytest
from django.conf import settings
from playwright.sync_api import expect

from queueing import services as queue
from queueing.models import Ticket, Turn
from robots import bus, services
from robots.bus import web_uptime
from robots.kit.clock import SYSTEM
from robots.models import Robot
from tests.conftest import at_length, wait_for
from tests.e2e.bare import portal as portal
from tests.e2e.drawn import QUIET
from tests.e2e.told_line import ToldLine, own_time

PHONE, DESKTOP = {"width": 390, "height": 844}, {"width": 1440, "height": 900}
IDLE_S = settings.FARHAND["IDLE_S"]
BAR, ALERT = "#turnbar", "[role=alert][aria-live=assertive]"
WHERE = (
    "() => ['#screen', '[data-command=stop]', '#place'].map((s) => document.querySelector(s).getBoundingClientRect().y)"
)
# where the banner would be on a page that has been scrolled
BANNER = """() => { const banner = document.getElementById("banner"), was = scrollY;
  [banner.hidden, banner.style.display] = [false, ""]; scrollTo({ top: 400, behavior: "instant" });
  const { top } = banner.getBoundingClientRect(); banner.style.display = "none"; scrollTo({ top: was, behavior: "instant" }); return top; }"""


@pytest.fixture
def driving(portal, visitor):
    """Ada drives; Bob waits, on a page of his own."""

    def make(**options):
        ada, bob = visitor(**options).cleared("ada", None), visitor().cleared("bob", "/log/")
        portal.drive(ada.user, "mercury")
        ada.page.goto("/robots/mercury/")
        expect(ada.page.locator("#robot")).to_have_class(re.compile("operating"))
        queue.join(portal.robot, bob.user, SYSTEM.now())
        return ada

    return make


def idle(seconds):
    """Let nothing have been done for so long while somebody, who is there, waited; then advance the queues."""
    now = SYSTEM.now()
    at = now - timedelta(seconds=seconds)
    up_for_long()
    Turn.objects.filter(ended_at=None).update(started_at=at)
    Ticket.objects.filter(state="waiting").update(joined_at=at, last_seen=now)
    queue.tick(now)


def up_for_long():
    """Let people have reached the portal for an hour."""
    began = SYSTEM.now() - timedelta(hours=1)
    bus.connection().set(bus.web_up_key(), began.timestamp(), ex=web_uptime.LASTS_S)


@pytest.mark.parametrize("size", [PHONE, at_length(DESKTOP)], ids=["phone", "desktop"])
def test_who_does_nothing_is_asked_in_time_and_stays_by_the_keyboard(portal, visitor, size):
    ada, bob = visitor(viewport=size).cleared("ada", None), portal.person("bob", "mercury")
    portal.drive(ada.user, "mercury")
    page, bar = ada.page, ada.page.locator(BAR)
    own_time(page)
    line = ToldLine(page, ada.user)
    page.goto("/robots/mercury/")
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))
    page.evaluate(QUIET)
    long_ago = line.now - timedelta(seconds=IDLE_S - 21)  # a clock that ran on would let the page lose its robot
    queue.join(portal.robot, bob, long_ago)
    Turn.objects.update(started_at=long_ago)
    line.tell()
    expect(bar).to_be_hidden()
    before = page.evaluate(WHERE)
    line.go(1)
    line.tell()
    expect(bar).to_contain_text(re.compile(r"Your turn ends in\s*20 s\s*because nothing was done"))
    assert page.evaluate(WHERE) == before, "nothing is pushed around"
    expect(page.locator(ALERT)).to_contain_text("because nothing was done")
    assert bar.bounding_box()["y"] == 0, "it lies over the head of the page, not beside Stop"
    assert bar.bounding_box()["height"] < 70, "one line, the button beside the words"
    expect(bar.locator(".simulated")).to_have_count(0)
    assert page.evaluate(BANNER) >= bar.bounding_box()["height"] - 1
    page.locator("#screen").focus()
    page.keyboard.press("Shift+Tab")
    expect(page.get_by_role("button", name="I'm here")).to_be_focused()
    page.keyboard.press("Enter")
    expect(bar).to_be_hidden()
    expect(page.locator("#screen")).to_be_focused()
    assert Turn.objects.get().acted_at == line.now
    Turn.objects.update(acted_at=long_ago)
    line.tell()
    expect(bar).to_be_visible()
    page.clock.resume()  # axe has to wait
    ada.axe("idle")


@pytest.mark.timed
def test_the_end_for_idleness_is_told_everywhere_with_its_reason(portal, driving, visitor):
    ada = driving(viewport=PHONE)
    page, elsewhere = ada.page, ada.context.new_page()
    elsewhere.goto(page.url.split("/robots/")[0] + "/log/")
    idle(IDLE_S + 1)
    why = "Nothing was done for 2 min while others waited."
    expect(page.locator("#place")).to_contain_text(why)
    expect(page.locator("#place")).to_contain_text("Only the 2 min")
    expect(page.locator("#notice")).to_contain_text(why)
    assert "Thank you" not in page.inner_text("body")
    page.reload()
    expect(page.locator("#place")).to_contain_text(why)
    page.goto(f"/turns/{Turn.objects.get().pk}/")
    expect(page.locator("main")).to_contain_text(why)
    ada.axe("the turn's page")


@pytest.mark.timed
def test_a_lock_out_says_so_on_the_page_of_who_drove_and_on_others(portal, driving, django_user_model):
    ada, kim = driving(), django_user_model.objects.create_superuser("kim", "kim@example.org", "correct horse 42")
    page, phone = ada.page, ada.context.new_page()
    phone.goto(page.url.split("/robots/")[0] + "/log/")
    expect(phone.locator(BAR)).to_contain_text("You operate Mercury")
    page.close()  # in her pocket
    services.lock_out(Robot.objects.get(pk=portal.robot.pk), kim, "A leaf lies in the sand.")
    queue.tick(SYSTEM.now())
    try:
        expect(phone.locator(BAR)).to_contain_text(
            re.compile(
                r"Your turn on Mercury ended at .*Staff closed the robot to everybody\. Only the .* that you had"
            )
        )
        phone.get_by_role("link", name="What did you find?").click()
        expect(phone.locator("main")).to_contain_text("Staff closed the robot to everybody.")
        wait_for(
            lambda: phone.wait_for_timeout(50) or Ticket.objects.get(user=ada.user).dismissed_at, 10, "it was read"
        )
        phone.goto("/robots/mercury/")
        expect(phone.locator("#place")).to_contain_text("Your turn is over")
        expect(phone.locator("#place")).to_contain_text("when staff open the robot again")
    finally:
        services.lift_lock_out(Robot.objects.get(pk=portal.robot.pk), kim)


@pytest.mark.timed
def test_without_scripts_the_console_says_the_rule_and_the_reason(portal, visitor):
    ada, bob = visitor(java_script_enabled=False).cleared("ada", None), visitor().cleared("bob", "/log/")
    queue.join(portal.robot, ada.user, SYSTEM.now(), classic=True)
    portal.picture("mercury", 0)
    portal.serve()
    page = ada.page
    page.goto("/classic/mercury/")
    page.locator("main").get_by_role("button", name="Take control").click()
    expect(page.locator("main")).to_contain_text("Nobody else waits. This page updates by itself after 60 s.")
    queue.join(portal.robot, bob.user, SYSTEM.now())
    at = SYSTEM.now() - timedelta(seconds=160)
    up_for_long()
    Turn.objects.update(started_at=at, until=SYSTEM.now() + timedelta(seconds=200))
    Ticket.objects.filter(user=bob.user).update(joined_at=at)
    page.get_by_role("link", name="Update").click()
    expect(page.get_by_role("alert")).to_contain_text(
        re.compile(r"Your turn ends in (20|1\d) s, because nothing was done")
    )
    page.get_by_role("button", name="I'm here").click()
    calm = re.compile(r"Others wait: your turn ends if you do nothing for 1[78]\d s\.")
    expect(page.locator("main")).to_contain_text(calm)
    expect(page.get_by_role("alert")).to_have_count(0)
    Turn.objects.update(acted_at=at - timedelta(seconds=30))
    Ticket.objects.filter(user=bob.user).update(joined_at=at - timedelta(seconds=30))
    Turn.objects.update(started_at=at - timedelta(seconds=30))
    queue.tick(SYSTEM.now())
    page.get_by_role("link", name="Update").click()
    expect(page.locator("main")).to_contain_text("Your turn is over. Nothing was done for 3 min while others waited.")
