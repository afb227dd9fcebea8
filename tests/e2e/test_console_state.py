"""A console shows the present state: gamepads, refusals, the cross, the fields of a pose, the screen."""

import io
import time

import pytest
from PIL import Image
from playwright.sync_api import expect

from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.packets import picture_packet
from robots.models import Command, Robot
from tests.conftest import wait_for
from tests.e2e import bare as told
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

PAD = """
window.pad = { id: "A pad", index: 0, mapping: "", connected: true, axes: [0, 0, 0, 0, 0, 0], buttons: [] };
navigator.getGamepads = () => [window.pad];
Object.defineProperty(document, "hasFocus", { value: () => true });
"""
LOCKS = """
window.locks = [];
Object.defineProperty(navigator, "wakeLock", { value: { request: async () => {
  const lock = { released: false, release: async () => { lock.released = true; } };
  locks.push(lock);
  return lock;
} } });
"""
HELD = "locks.filter((lock) => !lock.released).length"
TICKS = 300  # ms; the page reads a gamepad every 40 ms


@pytest.fixture
def driving(portal, visitor):
    def make(robot, script=""):
        one = visitor(viewport={"width": 1440, "height": 900})
        one.context.add_init_script(script)
        one.user = portal.person("ada", robot)
        one.turn = portal.drive(one.user, robot)
        session(one, one.user)
        one.page.goto(portal.robots[robot].get_absolute_url())
        one.page.wait_for_selector(".operating")
        expect(one.page.locator("#why")).not_to_contain_text("not known")  # a state has come
        return one

    return make


def axes(page, *values):
    page.evaluate("(axes) => { pad.axes = [...axes, 0, 0, 0, 0, 0, 0].slice(0, 6); }", list(values))
    page.wait_for_timeout(TICKS)


def test_a_trigger_that_rests_at_minus_one_moves_no_arm_and_the_page_says_what_counts(driving):
    page = driving("pa10", PAD).page
    page.click("#tab-position")
    hint = page.locator("#tool-jog .hint")
    expect(hint).to_contain_text("only the left stick counts")
    axes(page, 0, 0, -1, 0, 0, -1)
    axes(page, 0, 0, -1, -1, 0, -1)
    assert not Command.objects.exists()
    axes(page, 0, -1, -1, 0, 0, -1)
    wait_for(lambda: page.wait_for_timeout(50) or Command.objects.exists(), 10, "the left stick works")
    assert Command.objects.get().args == {"x": 1}


def test_a_stick_that_is_pushed_as_the_stop_is_released_begins_nothing(driving, portal):
    one = driving("mercury", PAD)
    page, robot = one.page, portal.robots["mercury"]
    services.stop(robot, one.user, SYSTEM.now())
    expect(page.locator("#release")).to_be_visible()
    axes(page, 1, 0)
    expect(page.locator("#notice")).to_contain_text("release the stop")
    services.release_stop(Robot.objects.get(pk=robot.pk), one.user, True)
    expect(page.locator("#release")).to_be_hidden()
    page.wait_for_timeout(2 * TICKS)
    assert not Command.objects.exists()
    expect(page.locator("#jog .hint")).to_contain_text("release its sticks")
    axes(page, 0, 0)
    axes(page, 1, 0)
    wait_for(lambda: page.wait_for_timeout(50) or Command.objects.exists(), 10, "a new push")


def test_what_was_refused_is_not_said_after_another_command(driving):
    page = driving("mercury").page
    why, notice = page.locator("#why"), page.locator("#notice")
    page.locator("#schematic").click(position={"x": 12, "y": 12})
    expect(why).to_contain_text("off the sand")
    page.click("[data-command=go]", force=True)
    expect(notice).to_contain_text("off the sand")
    # at once, not when it would go by itself
    assert page.evaluate("""() => {
      document.querySelector("[data-command=up]").click();
      return [document.getElementById("notice").hidden, document.querySelector(".ghost-ring").getAttribute("cy")];
    }""") == [True, "9999"]
    expect(why).not_to_contain_text("off the sand")


def test_a_refusal_goes_with_the_next_choice(driving):
    page = driving("mercury").page
    page.click("[data-command=go]", force=True)
    expect(page.locator("#notice")).to_contain_text("choose where to go")
    assert page.evaluate("""() => {
      document.getElementById("schematic").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowUp" }));
      return document.getElementById("notice").hidden;
    }""")


def grey(still):
    """Return a live picture of now; `still`: the stored one that shows the same, 0 while the arm moves."""
    file = io.BytesIO()
    Image.new("L", (192, 165), 120).save(file, "JPEG")
    return picture_packet(int(time.time() * 1000) % 2**31, int(time.time() * 1000), still, (), file.getvalue())


def test_the_cross_goes_when_the_picture_beneath_it_does(driving):
    page = driving("mercury").page
    page.select_option("#pace", "live")
    expect(page.locator("#picture")).not_to_have_attribute("data-still", "0")
    still = int(page.get_attribute("#picture", "data-still"))
    cross = page.locator("#overlay .cross")
    page.locator("#screen").click(position={"x": 100, "y": 90})
    expect(cross).not_to_have_attribute("transform", "translate(-50 -50)")

    def shows(of):
        bus.publish_picture("mercury", grey(of))
        page.wait_for_timeout(100)
        return page.get_attribute("#picture", "data-still") == str(of)

    wait_for(lambda: shows(still), 20, "a live picture of the same place")
    expect(cross).not_to_have_attribute("transform", "translate(-50 -50)")
    wait_for(lambda: shows(0), 20, "a picture of the arm in motion")
    expect(cross).to_have_attribute("transform", "translate(-50 -50)")


def test_the_fields_of_a_pose_follow_the_arm_until_somebody_fills_them_in(driving, monkeypatch):
    page = driving("pa10").page
    page.click("#tab-position")
    x, take = page.locator("#pose-x"), page.locator("[data-fill=pose]")
    expect(x).not_to_have_value("", timeout=30_000)
    before = x.input_value()
    monkeypatch.setitem(told.JOINTS, "pa10", (0.6, 0.6, 1.2, 0.0, 1.3, 0.0, 0.05))
    expect(x).not_to_have_value(before)
    x.fill("512")
    after = page.input_value("#pose-y")
    monkeypatch.setitem(told.JOINTS, "pa10", (-0.6, 0.6, 1.2, 0.0, 1.3, 0.0, 0.05))
    expect(page.locator("#readings")).to_contain_text("-34.4°")
    assert (x.input_value(), page.input_value("#pose-y")) == ("512", after)
    take.click()
    expect(x).not_to_have_value("512")


def test_the_screen_stays_on_for_as_long_as_one_drives(driving, portal):
    one = driving("mercury", LOCKS)
    page = one.page
    wait_for(lambda: page.wait_for_timeout(50) or page.evaluate(HELD) == 1, 10, "a lock")
    portal.end(one.turn)
    wait_for(lambda: page.wait_for_timeout(50) or page.evaluate(HELD) == 0, 10, "no lock")
    assert page.evaluate("locks.length") == 1
