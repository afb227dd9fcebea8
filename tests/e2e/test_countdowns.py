"""Countdowns of the turn bar, of a robot's panel and of a pause: on the page's own clock, which only the test moves."""

import re
from datetime import timedelta

import pytest
from django.conf import settings
from playwright.sync_api import expect

from accounts.models import Attempt, Choice, OrientationRead
from accounts.services import load_bank
from queueing import services as queue
from queueing.models import Ticket, Turn
from robots.kit.clock import SYSTEM
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.drawn import QUIET
from tests.e2e.told_line import ToldLine, own_time, run_heard, stopped_clock
from tests.waiting import CEILING_S, wait_for

BAR = "#turnbar"
OFFER_S, KEPT_S, IDLE_S, PAUSE_S = (
    settings.FARHAND[name] for name in ("OFFER_S", "RECONNECT_S", "IDLE_S", "QUIZ_PAUSE_S")
)
# everything that a screen reader is told, and how urgently
LISTEN = """
() => { window.heard = []; for (const live of document.querySelectorAll("[aria-live]"))
  new MutationObserver(() => live.textContent && heard.push([live.getAttribute("aria-live"), live.textContent]))
    .observe(live, { childList: true, characterData: true, subtree: true }); }
"""


@pytest.fixture
def told(portal, visitor):
    """Open a page of the log whose clock stands, for somebody who is cleared and is told their places by hand."""

    def make(script="", **options):
        one = visitor(**options)
        one.user = portal.person("ada", "mercury")
        session(one, one.user)
        one.context.add_init_script(script)
        one.line = ToldLine(one.page, one.user)
        one.page.goto("/log/")
        one.bar = one.page.locator(BAR)
        one.timer = one.bar.locator("[role=timer]")
        return one

    return make


def offered(portal, one):
    queue.join(portal.robot, one.user, one.line.now)
    one.line.serve()
    expect(one.bar).to_contain_text("It is your turn on Mercury")


def test_an_offer_counts_down_is_told_at_its_moments_and_is_missed_at_its_end(portal, told):
    one = told()
    page, line = one.page, one.line
    offered(portal, one)
    assert page.title().startswith("▶ Your turn!")
    assert "icon-turn" in page.get_attribute("link[rel=icon]", "href")
    assert one.timer.get_attribute("aria-live") is None
    page.evaluate(LISTEN)
    for left in range(OFFER_S, 0, -1):
        expect(one.timer).to_have_text(f"0:{left:02}")
        line.go(1)
    expect(one.bar).to_be_hidden()
    assert page.evaluate("heard.filter(([, words]) => words.includes('left'))") == [
        ["assertive", "20 seconds left to take control of Mercury."],
        ["assertive", "10 seconds left to take control of Mercury."],
    ]
    line.serve()
    expect(one.bar).to_contain_text("You missed your turn on Mercury at")
    expect(page).to_have_title(re.compile("^! Missed turn"))


def test_a_page_in_the_background_whose_timers_do_not_run_is_told_all_the_same(portal, told):
    one = told("window.setInterval = () => 0;")
    page, line = one.page, one.line
    offered(portal, one)
    page.evaluate(LISTEN)
    for left in (20, 10):
        line.now += timedelta(seconds=10)  # the page's own clock stands, as in a tab that sleeps
        line.tell()
        page.wait_for_function("(left) => heard.some(([, words]) => words.startsWith(`${left} seconds`))", arg=left)
    line.now += timedelta(seconds=11)
    line.serve()
    expect(page).to_have_title(re.compile("^! Missed turn"))


def test_a_turn_whose_page_was_left_counts_down_how_long_it_is_kept(portal, told):
    one = told()
    line = one.line
    offered(portal, one)
    turn = queue.accept(portal.robot, one.user, line.now, away=True)
    line.tell()
    expect(one.bar).to_contain_text("Go back to Mercury, or your turn ends")
    for left in range(KEPT_S, 0, -1):
        expect(one.timer).to_have_text(f"0:{left:02}")
        line.go(1)
    line.go(1)
    line.serve()
    expect(one.bar).to_contain_text(re.compile("Your turn on Mercury ended at .*connection", re.IGNORECASE))
    turn.refresh_from_db()
    assert turn.ended_at == line.now


def test_an_idle_turn_counts_down_from_the_warning_and_ends_with_its_reason(portal, told):
    one = told()
    line = one.line
    bob = portal.person("bob", "mercury")
    offered(portal, one)
    queue.accept(portal.robot, one.user, line.now)
    queue.join(portal.robot, bob, line.now)
    line.tell()
    expect(one.bar).to_contain_text("You operate Mercury")
    line.go(IDLE_S - 21)
    line.tell()
    expect(one.bar).not_to_contain_text("nothing was done")
    line.go(1)
    line.tell()
    for left in range(20, 10, -1):
        expect(one.timer).to_have_text(f"{left} s")
        line.go(1)
    expect(one.bar).to_contain_text("because nothing was done")
    one.page.get_by_role("button", name="I'm here").click()
    expect(one.bar).to_contain_text("You operate Mercury")
    assert Turn.objects.get().acted_at == line.now
    line.go(IDLE_S + 1)
    Ticket.objects.update(last_seen=line.now)
    line.serve()
    expect(one.bar).to_contain_text("Nothing was done for 2 min while others waited.")


@pytest.fixture
def driving(portal, visitor):
    """Open the page of a robot whose clock stands, for who drives there."""
    one = visitor()
    user = portal.person("ada", "mercury")
    portal.drive(user, "mercury")
    session(one, user)
    stopped_clock(one.page)
    heard = own_time(one.page)
    one.page.goto("/robots/mercury/")
    expect(one.page.locator("#robot")).to_have_class(re.compile("operating"))
    wait_for(lambda: one.page.wait_for_timeout(0) or "pong" in heard, CEILING_S, "the server's time")
    run_heard(one.page, heard, 1000)
    expect(one.page.locator("#place [data-do=leave]")).to_be_visible()
    return one.page, heard


COUNT = """
() => { window.presses = 0;
  document.addEventListener("click", (event) => {
    if (!event.target.closest("#place [data-do=leave]")) return;
    window.presses += 1;
    event.stopImmediatePropagation();
  }, true); }
"""


def test_presses_and_focus_outlast_every_tick_of_the_panel(driving):
    page, heard = driving
    page.evaluate(COUNT)
    end, timer = page.locator("#place [data-do=leave]"), page.locator("#place [role=timer]")
    end.scroll_into_view_if_needed()
    box = end.bounding_box()
    for tick in range(20):
        before = timer.inner_text()
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        page.mouse.down()
        run_heard(page, heard, 1000 + 250 * (tick % 3))
        expect(timer).not_to_have_text(before)
        page.mouse.up()
    assert page.evaluate("presses") == 20
    assert Turn.objects.filter(ended_at=None).count() == 1
    page.evaluate("""() => { window.lost = 0; window.kept = document.querySelector('#place [data-do=leave]');
      kept.focus(); kept.addEventListener('blur', () => window.lost++); }""")
    for _ in range(3):
        before = timer.inner_text()
        run_heard(page, heard, 1000)
        expect(timer).not_to_have_text(before)
    assert page.evaluate("document.activeElement === kept && kept.isConnected")
    assert page.evaluate("lost") == 0


def test_ending_the_turn_is_asked_in_place_for_a_while_and_a_double_click_is_one_press(driving):
    page, heard = driving
    page.evaluate(QUIET)
    end = page.locator("#place [data-do=leave]")
    before = end.bounding_box()
    end.dblclick()
    expect(end).to_have_text("Press again to end it")
    run_heard(page, heard, 1000)
    expect(page.locator("#place")).to_contain_text("You cannot undo this")
    after = end.bounding_box()
    assert (after["x"], after["y"], after["height"]) == (before["x"], before["y"], before["height"])
    run_heard(page, heard, 6000)
    expect(end).to_have_text("Press again to end it")
    assert Turn.objects.get().ended_at is None, "a double click is one press"
    run_heard(page, heard, 2000)
    expect(end).to_have_text("End my turn")
    end.click()
    run_heard(page, heard, 500)
    end.click()
    expect(page.locator("#place")).to_contain_text("Write in the operator's log")
    assert Turn.objects.get().ended_at is not None


def test_the_pause_after_a_failed_test_counts_down_and_then_the_link_works(portal, visitor):
    eve = portal.person("eve")
    load_bank(portal.robot)
    OrientationRead.objects.create(user=eve, robot=portal.robot, at=SYSTEM.now())
    Attempt.objects.create(  # the first failure costs no pause
        user=eve, robot=portal.robot, drawn=[], started_at=SYSTEM.now(), finished_at=SYSTEM.now(), passed=False
    )
    one = session(visitor(), eve)
    page = one.page
    stopped_clock(page)
    page.goto("/robots/mercury/clearance/")
    wrong = set(Choice.objects.filter(correct=False).values_list("pk", flat=True))
    for group in page.locator("main fieldset").all():
        next(box for box in group.locator("input").all() if int(box.get_attribute("value")) in wrong).check()
    page.click("main form button")
    again = page.locator("a[data-pause]")
    pause = int(again.get_attribute("data-pause"))
    assert 0 < pause <= PAUSE_S
    for left in range(pause, 0, -1):
        expect(again).to_have_text(f"Try again in {left // 60}:{left % 60:02}")
        page.clock.run_for(1000)
        if left == pause:
            expect(again).to_have_attribute("aria-disabled", "true")
            again.click(force=True)
            expect(page.locator("main")).to_contain_text("Not yet")
    expect(again).to_have_text("Try again")
    expect(page.locator("#pause-said")).to_have_text("You can try again now.")
    for attempt in Attempt.objects.all():  # as long ago for the server
        attempt.finished_at -= timedelta(seconds=PAUSE_S)
        attempt.save()
    again.click()
    expect(page.locator("main form fieldset").first).to_be_visible()
