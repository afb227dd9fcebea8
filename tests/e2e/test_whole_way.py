"""A stranger's whole way, by two people at once, in a real browser on a real portal."""

import re

import pytest
from playwright.sync_api import expect

from operatorlog.models import Entry, SurveyResponse
from portal.keep.seeding import SURVEY
from queueing.models import Turn
from robots.models import Command, Robot
from tests.conftest import wait_for
from tests.e2e.conftest import session
from tests.e2e.newcomer import end_turn

pytestmark = pytest.mark.timed


@pytest.fixture
def survey(db):
    from operatorlog.models import SurveyQuestion

    for position, (prompt, kind, options, low, high) in enumerate(SURVEY):
        SurveyQuestion.objects.create(
            prompt=prompt, kind=kind, options="\n".join(options), low_label=low, high_label=high, position=position
        )


def test_two_people_one_drives_the_other_waits_and_then_gets_the_turn(transactional_db, portal, visitor, survey):
    watcher = visitor()
    watcher.page.goto("/robots/mercury/")
    expect(watcher.page.locator("#age")).to_contain_text("Picture")
    expect(watcher.page.locator("#controls")).to_be_hidden()

    ada = visitor().sign_up("ada").get_cleared()
    bob = visitor().cleared("bob")
    ada.page.click("[data-do=take]")
    expect(ada.page.locator("#robot")).to_have_class(re.compile("operating"))
    bob.page.click("[data-do=join]")
    expect(bob.page.locator("#place")).to_contain_text("You are next")
    expect(bob.page).to_have_title(re.compile(r"^\(1\) "))
    expect(watcher.page.locator("#operator")).to_have_text("ada drives")
    expect(watcher.page.locator("#queue")).to_have_text("1 waiting")

    # a click in the camera image shows the ghost first and moves only when confirmed
    screen = ada.page.locator("#screen")
    expect(ada.page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "false")
    box = screen.bounding_box()
    screen.click(position={"x": box["width"] * 0.7, "y": box["height"] * 0.35})
    assert Command.objects.filter(kind="move").count() == 0
    expect(ada.page.locator(".ghost-arm")).not_to_have_attribute("points", "")
    *_, x, y = ada.page.locator("#overlay .path").evaluate(
        "(p) => ['x1', 'y1', 'x2', 'y2'].map((end) => +p.getAttribute(end))"
    )
    assert ada.page.get_attribute("#overlay .cross", "transform") == f"translate({x} {y})", "the path leads there"
    assert "Done" in ada.press("go")
    expect(watcher.page.locator("#ladder li").first).to_contain_text("Done")
    air = ada.page.locator("[data-command=air]")
    expect(air).to_have_attribute("aria-disabled", "true")

    def refused():
        """Press again where a late state was the reason that was given."""
        air.click(force=True)
        ada.page.wait_for_timeout(200)
        return "press Down first" in ada.page.locator("#notice").inner_text()

    wait_for(refused, 15, "the reason of the refusal")
    ada.press("down")
    ada.press("air")
    expect(ada.page.locator("#before")).to_be_visible()
    ada.press("up")
    # by keyboard alone, in the map
    ada.page.locator("#schematic").focus()
    for _ in range(3):
        ada.page.keyboard.press("Shift+ArrowLeft")
    expect(ada.page.locator("[data-command=go]")).to_have_attribute("aria-disabled", "false")
    sent = Command.objects.count()
    ada.page.keyboard.press("Enter")
    wait_for(lambda: Command.objects.count() > sent, 10, "the command of the Enter key")
    ada.ladder()
    assert portal.sim.count("burst") == 1
    assert portal.sim.status()["pose"][0] < 0

    end_turn(ada.page)
    expect(ada.page.locator("#place")).to_contain_text("Your turn is over")
    bob.page.locator("[data-do=accept]").click(timeout=30_000)
    expect(bob.page.locator("#robot")).to_have_class(re.compile("operating"))
    expect(watcher.page.locator("#operator")).to_have_text("bob drives")

    ada.page.click("text=Write in the operator's log")
    ada.page.fill("#text", "A burst of air left a hole beside the middle. ¿Señales?")
    ada.page.locator("input[type=radio][name^=s]").first.check()
    ada.page.click("main form button")
    expect(ada.page.locator("main")).to_contain_text("It is in the log, and your answers are kept")
    assert Entry.objects.get().frame is not None
    assert SurveyResponse.objects.count() == 1
    expect(watcher.page.locator("#log")).to_contain_text("A burst of air left a hole")
    assert Turn.objects.filter(ended_at=None).get().user.username == "bob"


def operating(visitor, name="ada"):
    one = visitor().cleared(name)
    one.page.click("[data-do=take]")
    expect(one.page.locator("#robot")).to_have_class(re.compile("operating"))
    expect(one.page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "false")
    return one


def test_stop_is_always_there_and_wants_a_look_before_release(portal, visitor):
    Robot.objects.update(settings={"speed": 0.05})
    ada = operating(visitor)
    ada.page.locator("#schematic").focus()
    for _ in range(3):
        ada.page.keyboard.press("Shift+ArrowRight")
    ada.page.keyboard.press("Enter")
    wait_for(lambda: portal.sim.status()["moving"], 5, "a motion")
    ada.page.keyboard.press("Escape")
    wait_for(lambda: not portal.sim.status()["moving"], 2, "the hold")
    ada.ladder("cancelled")
    expect(ada.page.locator("#release")).to_be_visible()
    expect(ada.page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "true")
    ada.page.click("[data-command=release]")
    expect(ada.page.locator("#notice")).to_contain_text("Look at the newest picture")
    ada.page.check("#checked")
    ada.page.click("[data-command=release]")
    expect(ada.page.locator("#release")).to_be_hidden()
    ada.press("down")


def test_a_click_off_the_sand_is_refused_where_it_was_made(portal, visitor):
    ada = operating(visitor)
    box = ada.page.locator("#schematic").bounding_box()
    ada.page.locator("#schematic").click(position={"x": box["width"] * 0.5, "y": box["height"] * 0.85})
    expect(ada.page.locator("#why")).to_contain_text("off the sand")
    expect(ada.page.locator("[data-command=go]")).to_have_attribute("aria-disabled", "true")
    before = portal.sim.count("motion")
    ada.page.keyboard.press("Enter")
    assert Command.objects.filter(kind="move").count() == 0
    assert portal.sim.count("motion") == before


def test_a_reload_keeps_the_turn_and_a_cut_line_disables_every_control(portal, visitor):
    ada = operating(visitor)
    ada.page.reload()
    expect(ada.page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "false")
    assert Turn.objects.count() == 1
    ada.allowed = ("ERR_", "WebSocket")
    portal.web.kill()
    expect(ada.page.locator("#banner")).to_contain_text("Connection lost")
    for name in ("go", "up", "down", "air"):
        expect(ada.page.locator(f"[data-command={name}]")).to_have_attribute("aria-disabled", "true")
    expect(ada.page.locator("#why")).to_contain_text("kept for 20 seconds")


def test_redis_gone_shows_a_banner_and_comes_back(portal, visitor, redis_server):
    ada = operating(visitor)
    ada.allowed = ("503 (Service Unavailable)",)  # a code for the operator's stream may be asked for just then
    redis_server.stop()
    expect(ada.page.locator("#banner")).to_contain_text("live link")
    expect(ada.page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "true")
    assert ada.page.request.get("/status/").ok
    redis_server.start()
    expect(ada.page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "false", timeout=20_000)
    ada.press("down")


def test_a_killed_worker_is_told_in_plain_words(portal, visitor):
    from tests.rig import worker

    Robot.objects.update(settings={"speed": 0.05})
    ada = operating(visitor)
    ada.page.locator("#schematic").focus()
    for _ in range(3):
        ada.page.keyboard.press("Shift+ArrowRight")
    ada.page.keyboard.press("Enter")
    wait_for(lambda: portal.sim.status()["moving"], 5, "a motion")
    portal.worker.kill()
    expect(ada.page.locator("#why")).to_contain_text("waiting for it")
    portal.worker = worker()
    expect(ada.page.locator("#ladder li").first).to_contain_text("Unknown", timeout=20_000)
    expect(ada.page.locator("#ladder li").first).to_contain_text("Look at the new picture")
    expect(ada.page.locator("[data-command=down]")).to_have_attribute("aria-disabled", "false", timeout=20_000)


def test_axe_finds_nothing_while_driving_nor_after(portal, visitor, survey):
    ada = operating(visitor)
    ada.axe("driving")
    ada.press("down")
    ada.page.click("[data-command=stop]")
    expect(ada.page.locator("#release")).to_be_visible()
    ada.axe("stopped")
    ada.page.set_viewport_size({"width": 360, "height": 640})
    ada.axe("phone")
    ada.page.set_viewport_size({"width": 1280, "height": 860})
    end_turn(ada.page)
    ada.page.click("text=Write in the operator's log")
    ada.axe("turn")


def test_the_keeper_tests_resets_and_watches_the_wire(portal, visitor, django_user_model):
    django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")
    kim = visitor()
    kim.page.goto("/")
    session(kim, django_user_model.objects.get(username="root"))
    kim.page.goto(f"/admin/robots/robot/{portal.robot.pk}/change/")
    kim.page.click("text=Test connection")
    expect(kim.page.locator(".farhand-status")).to_contain_text("Take a picture: Done", timeout=20_000)
    kim.page.fill("[name=note]", "cleaning the lens")
    kim.page.click("button:has-text('Lock out')")
    expect(kim.page.locator(".farhand-status")).to_contain_text("Locked out")
    kim.page.click("button:text-is('Maintenance')")
    kim.page.wait_for_url("**/robots/mercury/")
    expect(kim.page.locator("#release")).to_be_visible()
    kim.page.check("#checked")
    kim.page.click("[data-command=release]")
    expect(kim.page.locator("#trace li").first).to_be_visible(timeout=20_000)
    kim.press("down")
    expect(kim.page.locator("#trace")).to_contain_text("MOVE_XYZ")
    expect(kim.page.locator("#trace")).to_contain_text("DONE")
