"""The mode "Scene" of an arm's console: the ghost of the tool by mouse and by keyboard, planned in the page, sent once."""

import re

import pytest
from playwright.sync_api import expect

from robots.kit.arms.described import chain
from robots.kit.arms.pose import numbers
from robots.models import Command
from tests.e2e.ghost import AT_THE_ARM, drive

# drawing in three dimensions without a graphics card takes a core of its own
pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["pa10"], indirect=True)]

WIDE = {"viewport": {"width": 1440, "height": 900}}
PHONE = {"viewport": {"width": 390, "height": 844}, "color_scheme": "dark"}
STANDS_STILL = "() => { setTimeout(() => { const end = performance.now() + 2000; while (performance.now() < end); }); }"


@pytest.fixture
def operator(visitor):
    def make(**options):
        person = drive(visitor(**options), 20_000)
        person.page.wait_for_timeout(500)
        person.wire.sent.clear()
        return person

    return make


def tool(portal):
    """Return where the simulated arm's tool is: m and rad."""
    return numbers(chain(portal.robot.driver).forward(portal.sim.status()["q"][:6]))


def assert_there(portal):
    """See that the arm's tool is at the place of the newest command, within 1 mm."""
    args = Command.objects.order_by("-pk")[0].args
    assert tool(portal)[:3] == pytest.approx([args[name] for name in "xyz"], abs=1e-3)
    return args


def grip(page):
    """Move the mouse over the view until it is on a handle; return where."""
    box = page.locator("#model canvas").bounding_box()
    for share_y in range(20, 96, 3):
        for share_x in range(20, 96, 3):
            x, y = box["x"] + box["width"] * share_x / 100, box["y"] + box["height"] * share_y / 100
            page.mouse.move(x, y)
            if page.evaluate("document.querySelector('#model canvas').style.cursor") == "grab":
                return x, y
    raise AssertionError("no handle was found under the mouse")


def drag(page, right, down):
    """Pull a handle of the ghost so far (px). On a busy machine the page may stand still, and let it go: then once more."""
    for _ in range(4):
        x, y = grip(page)
        page.mouse.down()
        for step in range(1, 11):
            page.mouse.move(x + right * step / 10, y + down * step / 10)
            page.wait_for_timeout(60)
        page.mouse.up()
        page.wait_for_timeout(1200)  # one sentence a second
        if "stood still" not in page.inner_text("#model-said"):
            break
    expect(page.locator("#model-said")).to_contain_text("s on the way")


def test_by_mouse_the_ghost_is_put_somewhere_and_the_arm_follows_once_it_is_sent(transactional_db, portal, operator):
    ada = operator(**WIDE)
    page = ada.page
    before = tool(portal)
    drag(page, -60, 20)
    expect(page.locator("#ghost-list")).to_contain_text("From the arm: ")
    assert ada.wire.kinds == set(), "a ghost leaves the wire silent"
    assert not Command.objects.exists()
    assert tool(portal)[:3] == pytest.approx(before[:3], abs=1e-3), "nothing moves before it is sent"
    # taken again at another point of its handles it does not leap
    told = page.inner_text("#ghost-list")
    grip(page)
    page.mouse.down()
    page.mouse.up()
    page.wait_for_timeout(1200)
    assert page.inner_text("#ghost-list") == told
    ada.wire.closed = 0
    # full screen, there and back, leaves ghost and sockets alone
    page.evaluate("document.documentElement.requestFullscreen()")
    page.wait_for_function("document.fullscreenElement !== null")
    page.evaluate("document.exitFullscreen()")
    page.wait_for_function("document.fullscreenElement === null")
    assert (page.inner_text("#ghost-list"), ada.wire.closed) == (told, 0)
    page.locator("[data-command=send-ghost]").first.dblclick()
    expect(page.locator("#notice").get_by_text("The arm is on its way there already.")).to_be_visible()
    ada.ladder("completed")
    assert ada.wire.sent.count("command") == 1, "a second press sends nothing"
    args = assert_there(portal)
    assert max(abs(args[name] - there) for name, there in zip("xyz", before, strict=False)) > 0.005
    expect(page.locator("#model-said")).to_have_text(AT_THE_ARM)
    ada.axe("the scene, wide")


def test_by_keyboard_alone(transactional_db, portal, operator):
    ada = operator(**PHONE)
    page = ada.page
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.focus("#tab-scene")
    for _ in range(20):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id") == "ghost-handle":
            break
    expect(page.locator("#ghost-handle")).to_be_focused()
    before = tool(portal)
    page.keyboard.press("+")
    for key in ("ArrowLeft", "ArrowLeft", "PageDown", "Shift+ArrowLeft"):
        page.keyboard.press(key)
    expect(page.locator("#ghost-list")).to_contain_text("40 mm left, 20 mm down, 15° about z")
    expect(page.locator("#ghost-list")).to_contain_text(re.compile("To the grasp of (red|yellow|blue|green): "))
    expect(page.locator("#objects-list li")).to_have_count(4)
    # down to the table: it stays above, and says why
    for _ in range(30):
        page.keyboard.press("PageDown")
    expect(page.locator("#model-said")).to_contain_text("would enter the table")
    for _ in range(5):
        page.keyboard.press("PageUp")
    expect(page.locator("#model-said")).to_contain_text("s on the way")
    assert ada.wire.kinds == set(), "a ghost leaves the wire silent"
    assert tool(portal)[:3] == pytest.approx(before[:3], abs=1e-3)
    page.keyboard.press("Enter")
    ada.ladder("completed")
    args = assert_there(portal)
    assert args["y"] == pytest.approx(before[1] + 0.04, abs=1e-3)
    expect(page.locator("#ghost-list")).to_contain_text(AT_THE_ARM)
    page.keyboard.press("ArrowUp")
    expect(page.locator("#ghost-list")).to_contain_text("forward")
    page.keyboard.press("g")
    expect(page.locator("#ghost-list")).to_contain_text(AT_THE_ARM)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    ada.axe("the scene on a phone")
    page.keyboard.press("Escape")
    expect(page.locator("#stop-said")).to_have_text("The robot is stopped")


def test_what_the_server_refuses_leaves_the_ghost_where_it_is(transactional_db, portal, operator):
    ada = operator(**WIDE)
    page = ada.page
    page.focus("#ghost-handle")
    page.keyboard.press("+")
    for _ in range(6):
        page.keyboard.press("ArrowLeft")
    expect(page.locator("#model-said")).to_contain_text("s on the way")
    told = page.inner_text("#ghost-list").split("\n")[:2]
    # meanwhile staff have put something there, which this page does not know
    place = tool(portal)
    low, high = [place[0] - 0.1, 0.1, 0.0], [place[0] + 0.1, 0.3, 1.2]
    portal.robot.settings = {"boxes": [{"name": "the new vase", "low": low, "high": high}]}
    portal.robot.save(update_fields=["settings"])
    page.keyboard.press("Enter")
    text = ada.ladder("rejected")
    assert "the new vase" in text
    expect(page.locator("#model-said")).to_contain_text("the new vase")
    assert page.inner_text("#ghost-list").split("\n")[:2] == told
    assert tool(portal)[:3] == pytest.approx(place[:3], abs=1e-3)


def test_a_page_that_stood_still_lets_the_ghost_go(transactional_db, portal, operator):
    ada = operator(**WIDE)
    page = ada.page
    x, y = grip(page)
    page.mouse.down()
    page.mouse.move(x - 20, y)
    expect(page.locator("#ghost-list")).to_contain_text("From the arm: ")
    page.wait_for_timeout(400)
    told = page.inner_text("#ghost-list").split("\n")[:2]
    # the page stands still for two seconds, while the hand goes far
    page.evaluate(STANDS_STILL)
    page.mouse.move(x - 200, y - 60)
    page.wait_for_timeout(2600)
    expect(page.locator("#model-said")).to_contain_text("stood still")
    page.mouse.move(x - 150, y - 60)
    page.wait_for_timeout(400)
    assert page.inner_text("#ghost-list").split("\n")[:2] == told, "it does not lurch"
    page.mouse.up()
    assert ada.wire.kinds == set()
