"""The admin's first page in a browser: cards follow their robots without a reload, and nothing needs a script."""

import re

import pytest
from playwright.sync_api import expect

from operatorlog.models import Entry
from queueing import services as queue
from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Grant, Incident, Robot
from robots.states import Cycle, GrantKind
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.test_axe import DARK, LIGHT
from tests.e2e.test_layout import OVER

MARK = "window.mark = 1"
SAME = "window.mark === 1"
SMALL = """() => [...document.querySelectorAll('#live button, #live summary, #live input:not([type=hidden])')].filter((e) => {
  const r = e.getBoundingClientRect();
  return r.height && (r.height < (e.matches('[type=checkbox]') ? 24 : 44) || r.width < 24);
}).map((e) => e.outerHTML)"""


@pytest.fixture
def staff(portal, visitor):
    """Open a browser of a superuser."""

    def make(**options):
        root = portal.person("root", is_staff=True, is_superuser=True)
        return session(visitor(**options), root)

    return make


def card(page, name="mercury"):
    return page.locator(f"#robot-{name}")


def test_stop_is_one_press_and_the_page_stays(portal, staff):
    page = staff(**LIGHT).page
    page.goto("/admin/")
    page.evaluate(MARK)
    card(page).get_by_text("Lock out or maintain").click()
    card(page).get_by_role("textbox").fill("a new belt")
    card(page).get_by_role("button", name="Stop Mercury").click()
    expect(card(page)).to_contain_text("stop pressed, not confirmed")
    expect(page.locator(".messagelist")).to_contain_text("Stop was sent.")
    expect(page.locator(".pending")).to_contain_text("Mercury is stopped")
    assert Robot.objects.get(pk=portal.robot.pk).stop_latched
    assert not Robot.objects.exclude(pk=portal.robot.pk).filter(stop_latched=True).exists()
    assert page.evaluate(SAME), "no reload"
    assert card(page).get_by_role("textbox").input_value() == "a new belt", "nothing written is lost"
    card(page).get_by_role("checkbox").check()
    card(page).get_by_role("button", name="Release the stop").click()
    expect(card(page)).not_to_contain_text("not confirmed")
    assert not Robot.objects.get(pk=portal.robot.pk).stop_latched


def test_the_answer_to_a_second_press_leaves_what_the_first_one_said(portal, staff):
    """One of two answers has both messages, and the other has none."""

    def answer_without_messages(route):
        answer = route.fetch()
        text = answer.text().replace('class="messagelist"', 'class="taken"').replace("nobody waits", "a second answer")
        route.fulfill(response=answer, body=text)

    page = staff(**LIGHT).page
    page.goto("/admin/")
    stop = card(page).get_by_role("button", name="Stop Mercury")
    stop.click()
    expect(page.locator(".messagelist")).to_contain_text("Stop was sent.")
    page.route("**/admin/live/", lambda route: None)  # no look replaces the second answer
    page.route("**/do/stop/", answer_without_messages)
    stop.click()
    expect(card(page)).to_contain_text("a second answer")
    expect(page.locator(".messagelist")).to_contain_text("Stop was sent.")


def test_a_lost_answer_leaves_open_whether_it_was_done(portal, staff):
    def lose_answer(route):
        route.fetch()
        route.abort()

    Robot.objects.filter(pk=portal.robot.pk).update(stop_latched=True, stopped_at=SYSTEM.now())
    one = staff(**LIGHT)
    one.allowed = ("Failed to load", "net::ERR")
    page = one.page
    page.goto("/admin/")
    page.route("**/do/release/", lose_answer)
    card(page).get_by_role("checkbox").check()
    card(page).get_by_role("button", name="Release the stop").click()
    expect(page.get_by_role("alert")).to_contain_text("it is not known whether it was done")
    assert not Robot.objects.get(pk=portal.robot.pk).stop_latched


def test_a_card_follows_its_robot_without_a_reload(portal, staff):
    page = staff(**DARK).page
    page.goto("/admin/")
    page.evaluate(MARK)
    expect(card(page)).to_contain_text("nobody waits")
    ada = portal.person("ada", "mercury")
    queue.join(portal.robot, ada, SYSTEM.now())
    expect(card(page)).to_contain_text("1 waiting: ada")
    Incident.objects.create(robot=portal.robot, at=SYSTEM.now(), code="x", text="The arm was silent.")
    expect(card(page)).to_contain_text("The arm was silent.", timeout=30_000)
    expect(page.locator(".pending")).to_contain_text("The arm was silent.")
    page.locator(".pending").get_by_role("button", name="Dealt with").click()
    expect(page.locator(".messagelist")).to_contain_text("Dealt with: 1 incident.")
    assert Incident.objects.get().closed_at is not None
    assert page.evaluate(SAME)


def test_a_hidden_page_asks_for_nothing(portal, staff):
    page = staff(**LIGHT).page
    page.goto("/admin/")
    page.evaluate("Object.defineProperty(document, 'hidden', { get: () => true, configurable: true })")
    page.wait_for_timeout(1500)  # a look that had begun
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.wait_for_timeout(11_000)
    assert [url for url in asked if "/admin/live/" in url] == []
    with page.expect_request(re.compile("/admin/live/")):
        page.evaluate(
            "Object.defineProperty(document, 'hidden', { get: () => false }); "
            "document.dispatchEvent(new Event('visibilitychange'))"
        )


def test_the_page_says_when_the_portal_is_not_reached(portal, staff):
    one = staff(**LIGHT)
    one.allowed = ("Failed to load", "net::ERR")
    page = one.page
    page.goto("/admin/")
    page.route("**/admin/**", lambda route: route.abort())
    card(page).get_by_role("button", name="Stop Mercury").click()
    expect(page.get_by_role("alert")).to_contain_text("The portal has not confirmed that")
    assert not Robot.objects.get(pk=portal.robot.pk).stop_latched
    page.unroute("**/admin/**")
    expect(page.get_by_role("alert")).to_be_hidden(timeout=30_000)


def test_all_of_it_works_without_scripts(portal, staff):
    entry = portal.entry(portal.person("ada", "mercury"), "mercury")
    page = staff(java_script_enabled=False).page
    page.goto("/admin/")
    card(page).get_by_role("button", name="Stop Mercury").click()
    assert page.locator(".messagelist").inner_text() == "Stop was sent."
    assert card(page).inner_text().count("stop pressed, not confirmed") == 1
    card(page).locator("summary").click()
    card(page).get_by_role("textbox").fill("a new belt")
    card(page).get_by_role("button", name="Lock out", exact=True).click()
    assert Robot.objects.get(pk=portal.robot.pk).cycle == Cycle.LOCKED_OUT
    page.get_by_role("button", name="Keep it published").click()
    assert page.url.endswith("/admin/")
    assert Entry.objects.get(pk=entry.pk).moderated_at is not None


@pytest.mark.parametrize("look", [LIGHT, DARK], ids=["wide", "narrow"])
def test_nothing_is_too_small_or_sticks_out_in_any_state(portal, staff, look):
    portal.entry(portal.person("ada", "mercury"), "mercury", "w" * 300)
    Incident.objects.create(robot=portal.robot, at=SYSTEM.now(), code="x", text="w" * 300)
    one = staff(**look)
    page = one.page
    page.goto("/admin/")
    for summary in page.locator("#live summary").all():
        summary.click()
    for fields in (
        {"stop_latched": True, "stop_confirmed": True, "stopped_at": SYSTEM.now()},
        {"stop_latched": False, "cycle": Cycle.LOCKED_OUT, "lockout_note": "w" * 200, "reason": "w" * 200},
    ):
        Robot.objects.filter(pk=portal.robot.pk).update(**fields)
        page.goto("/admin/")
        one.axe(str(fields))
        assert page.evaluate(SMALL) == []
        assert page.evaluate(OVER) == []
    Robot.objects.all().delete()
    page.goto("/admin/")
    expect(page.get_by_text("Add the first robot")).to_be_visible()
    one.axe("no robot")


def test_maintenance_leads_to_the_console_and_has_its_end_there(portal, staff):
    one = staff(**DARK)
    page = one.page
    page.goto("/admin/")
    card(page).get_by_text("Lock out or maintain").click()
    card(page).get_by_role("textbox").fill("a new belt")
    card(page).get_by_role("button", name="Lock out and drive it").click()
    page.wait_for_url(f"**{portal.robot.get_absolute_url()}")
    expect(page.locator("#place")).to_contain_text("Maintenance turn")
    assert Robot.objects.get(pk=portal.robot.pk).lockout_note == "a new belt"
    expect(page.locator("main")).to_contain_text("press “End maintenance”")
    end = page.locator("#place [data-do=leave]")
    expect(end).to_have_text("End maintenance")
    end.click()
    expect(page.locator("#place")).to_contain_text("stays locked out until staff lift that")
    one.axe("before its end")
    page.wait_for_timeout(500)  # a double click is one press
    end.click()
    expect(page.locator("#place")).not_to_contain_text("Maintenance turn")
    assert not Grant.objects.filter(robot=portal.robot, kind=GrantKind.STAFF, ended_at=None).exists()
    assert Robot.objects.get(pk=portal.robot.pk).cycle == Cycle.LOCKED_OUT


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        (services.end_maintenance, "The maintenance turn is over. The robot stays locked out."),
        (services.lift_lock_out, "Your turn is over."),
    ],
)
def test_who_maintains_a_robot_is_told_that_somebody_else_ended_it(portal, staff, ends, said):
    page = staff(**LIGHT).page
    page.goto("/admin/")
    card(page).get_by_text("Lock out or maintain").click()
    card(page).get_by_role("textbox").fill("a new belt")
    card(page).get_by_role("button", name="Lock out and drive it").click()
    expect(page.locator("#place")).to_contain_text("Maintenance turn")
    expect(page.locator(".messages")).to_contain_text("You drive now")
    ends(portal.robot, portal.person("lou", is_staff=True, is_superuser=True))
    expect(page.locator("#notice")).to_contain_text(said)
    expect(page.locator(".messages")).to_have_count(0)
