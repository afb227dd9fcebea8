"""The stage stays: whatever control is used, pictures, Stop, the time left and the next step are in view, on any robot."""

import re

import pytest
from playwright.sync_api import expect

from queueing import services as queue
from queueing.models import Account, Job, JobState
from robots import bus
from robots.kit.clock import SYSTEM
from tests.e2e.bare import JOINTS, BarePortal
from tests.e2e.conftest import session
from tests.e2e.drawn import QUIET, settle, size
from tests.e2e.stage import SIZES, assert_in_view
from tests.e2e.test_turn_bar import miss
from tests.packaged import TURNTABLE, installed_from, without_console
from tests.rig import Web
from tests.waiting import CEILING_S, wait_for

ARMS = {"pa10": JOINTS["pa10"], "puma": (0.26, 0.96, 1.48, 0.0, 0.7, 0.0)}
ALL = {"mercury": JOINTS["mercury"], **ARMS, "srv1": (), "irat": ()}
BAR = ["[data-command=stop]", "#place .timer", "[data-do=leave]", "#why"]
BESIDE = {"mercury": "#schematic", "pa10": "#model", "puma": "#model", "srv1": ".hall-map"}
TABS = "() => [...document.querySelectorAll('[role=tab]')].map((tab) => tab.id.slice(4))"
WHERE = """() => [...document.querySelectorAll("#stage-keep, #stage-view, #stage-view button, #controls button, #stage-bar, #stage-bar > *, #stage-bar button")]
  .filter((e) => e.checkVisibility()).map((e) => [e.id || e.textContent, ...Object.values(e.getBoundingClientRect().toJSON()).slice(0, 4)])"""
SHARE = """() => [...document.querySelectorAll("#stage-keep, #stage-view, #stage-bar")]
  .filter((e) => ["sticky", "fixed"].includes(getComputedStyle(e).position)).map((e) => e.getBoundingClientRect())
  .filter((box) => box.width > innerWidth * 0.6).reduce((sum, box) => sum + box.height, 0) / innerHeight"""
# where all is while these say something else; what the page has drawn is put back before it draws again
SAYING = """(texts) => {
  const were = Object.keys(texts).map((selector) => {
    const box = document.querySelector(selector), was = [...box.childNodes];
    box.innerHTML = texts[selector];
    return () => box.replaceChildren(...was);
  });
  const where = (%s)();
  for (const back of were) back();
  return where;
}"""
LONG = "The connection is lost; the page tries to connect again. Your turn is kept for 20 seconds. " * 3


@pytest.fixture
def portal(transactional_db, redis_server, house):
    bus.connection().flushall()
    made = BarePortal(house.web_process(), ALL)
    yield made
    made.stop()


@pytest.fixture(params=["own", "drawn"])
def packaged(request, transactional_db, redis_server, monkeypatch, tmp_path):
    """A portal with the robot of a package, which has a console of its own, or one that is drawn from its spec."""
    folder = TURNTABLE if request.param == "own" else without_console(tmp_path / "bare")
    with installed_from(folder, monkeypatch):
        bus.connection().flushall()
        web = Web()
        made = BarePortal(web, {"turntable": (0.3,)})
        yield made
        made.stop()
        web.kill()


def drives(portal, visitor, robot):
    """Give somebody a turn at the robot. Return their page."""
    user = portal.person("ada", robot)
    portal.drive(user, robot)
    one = session(visitor(), user)
    one.page.goto(portal.robots[robot].get_absolute_url())
    one.page.wait_for_selector(".operating")
    one.page.evaluate(QUIET)
    return one.page


@pytest.mark.parametrize("robot", [r for r in ALL if r != "irat"])
def test_whatever_control_is_used_the_views_stop_time_and_reason_are_in_view(portal, visitor, robot):
    page = drives(portal, visitor, robot)
    expect(page.locator(f"{BESIDE[robot]} *").first).to_be_attached()
    assert_in_view(page, ["#screen", BESIDE[robot], *BAR], modes=page.evaluate(TABS) or [""])


def test_so_they_are_on_the_page_of_a_package(packaged, chromium):
    from tests.e2e.conftest import Visitor

    one = Visitor(chromium, packaged)
    page = drives(packaged, lambda: one, "turntable")
    assert_in_view(page, ["#screen", *BAR])
    one.close()


def test_who_does_not_drive_has_view_and_next_step_in_view(portal, visitor):
    one = session(visitor(), portal.person("ada", "mercury", "pa10"))
    eve = visitor()
    for robot, who, step in [("mercury", one, "[data-do=take]"), ("pa10", eve, "#place a"), ("irat", eve, "#place a")]:
        page = who.page
        page.goto(portal.robots[robot].get_absolute_url())
        page.wait_for_selector(step)
        for wide, high in SIZES:
            size(page, wide, high)
            for selector in ("#screen", step):
                expect(page.locator(selector).first).to_be_in_viewport(ratio=1)
        if robot != "irat":  # whose goals everybody can set
            size(page, 1440, 900)
            assert page.locator("#screen").bounding_box()["width"] > 0.4 * 1440, (
                "the views have the room of the controls"
            )


@pytest.mark.parametrize("robot", ["mercury", "pa10"])
def test_the_release_is_in_view_and_covers_neither_the_picture_nor_the_bar(portal, visitor, robot):
    page = drives(portal, visitor, robot)
    page.click("[data-command=stop]")
    expect(page.locator("#release")).to_be_visible()
    assert_in_view(page, ["#screen", *BAR, "#checked", "[data-command=release]"])


def test_what_ended_elsewhere_takes_no_room_while_one_drives_and_is_told_after_it(portal, visitor):
    ada = portal.person("ada", "mercury", "pa10")
    queue.join(portal.robots["pa10"], ada, SYSTEM.now())
    portal.serve()
    miss()
    explores, now = portal.robots["irat"], SYSTEM.now()
    account = Account.objects.create(queue=explores.queue_link.queue, user=ada)
    Job.objects.create(queue=account.queue, robot=explores, account=account, user=ada, kind="explore", state=JobState.DONE,
                       asked_at=now, ended_at=now)  # fmt: skip
    turn = portal.drive(ada, "mercury")
    one = session(visitor(), ada)
    page, bar, ended = one.page, one.page.locator("#turnbar"), one.page.locator(".ended-jobs")
    page.goto(portal.robot.get_absolute_url())
    page.wait_for_selector(".operating")
    expect(bar).to_be_hidden()
    expect(ended).to_be_hidden()
    page.evaluate(QUIET)
    assert_in_view(page, ["#screen", "#schematic", *BAR], [(390, 844), (844, 390)])
    portal.end(turn)
    expect(bar).to_contain_text("You missed your turn on Museum arm")
    expect(ended).to_contain_text("Your job on iRat")


def test_the_bar_of_a_phone_says_what_became_of_the_last_command(portal, visitor):
    page = drives(portal, visitor, "mercury")
    page.click("[data-command=up]")
    last = page.locator("#last-command")
    expect(last).to_contain_text("Up")
    wait_for(lambda: page.wait_for_timeout(20) or portal.perform(), CEILING_S, "the command")
    expect(last).to_have_class(re.compile("completed"))
    assert_in_view(page, ["#last-command", *BAR], [(390, 844), (360, 640), (844, 390)])


@pytest.mark.parametrize("robot", ["mercury", "pa10", "puma", "srv1"])
def test_a_wide_screen_is_used_by_who_drives(portal, visitor, robot):
    page = drives(portal, visitor, robot)
    size(page, 1440, 900)
    usual = page.locator("#screen").bounding_box()
    size(page, 1920, 1080)
    settle(page)
    picture, side = (page.locator(s).bounding_box() for s in ("#screen", ".side"))
    assert picture["width"] * picture["height"] > 1.3 * usual["width"] * usual["height"]
    assert page.locator("#stage-keep").bounding_box()["x"] < 30
    assert side["x"] + side["width"] > 1890


@pytest.mark.parametrize("robot", ["mercury", "pa10"])
def test_nothing_of_bar_and_stage_moves_when_texts_change(portal, visitor, robot):
    page = drives(portal, visitor, robot)
    for wide, high in SIZES:
        size(page, wide, high)
        page.evaluate("scrollTo({ top: 0, behavior: 'instant' })")
        settle(page)
        before = page.evaluate(WHERE)
        for why, last, timer in [("", "", "0:07"), (LONG, f"<b>Move joints</b> <span class=chip>Failed</span> <span class=reason>{LONG}</span>", "59:59")]:  # fmt: skip
            moved = page.evaluate(SAYING % WHERE, {"#why": why, "#last-command": last, "#place .timer": timer})
            assert moved == before, (wide, high, why)


@pytest.mark.parametrize("robot", ["mercury", "pa10"])
def test_what_stays_leaves_room_for_the_controls(portal, visitor, robot):
    page = drives(portal, visitor, robot)
    for (wide, high), share in {
        (390, 844): 0.6,
        (360, 640): 0.65,
        (844, 390): 0.5,
        (640, 360): 0.5,
        (320, 256): 0.5,
    }.items():
        size(page, wide, high)
        page.evaluate("scrollTo({ top: 9999, behavior: 'instant' })")
        settle(page)
        assert page.evaluate(SHARE) < share, (wide, high)
        assert page.evaluate("document.documentElement.scrollWidth") <= wide


def test_one_button_chooses_between_the_views_and_the_choice_stays(portal, visitor):
    page = drives(portal, visitor, "pa10")
    size(page, 390, 844)
    button, picture, model = page.locator("#view-switch"), page.locator("#screen"), page.locator("#model")
    expect(button).to_have_accessible_name("Enlarge the 3D view")
    both = model.bounding_box()["width"]
    button.click()
    expect(picture).to_be_hidden()
    assert model.bounding_box()["width"] > 1.5 * both
    page.reload()
    expect(picture).to_be_hidden()
    expect(button).to_have_accessible_name("Picture alone")
    button.click()
    expect(model).to_be_hidden()
    expect(picture).to_be_visible()
    expect(button).to_have_accessible_name("Both views")
    button.click()
    expect(model).to_be_visible()
    assert page.evaluate("document.activeElement.id") == "view-switch"


def test_the_bar_says_why_the_control_that_has_the_focus_is_off(portal, visitor):
    page = drives(portal, visitor, "mercury")
    off = page.locator("#controls .button[data-why]:not([data-why='']):not([data-command=go])").first
    page.locator("#screen").focus()
    expect(page.locator("#why")).not_to_have_text(off.get_attribute("data-why"))
    off.focus()
    expect(page.locator("#why")).to_have_text(off.get_attribute("data-why"))
    page.click("[data-command=stop]")
    expect(page.locator("#why")).to_contain_text("release the stop")
