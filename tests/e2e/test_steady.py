"""Nothing moves under a finger: whatever the page shows, its buttons stay where they are."""

from contextlib import contextmanager

import pytest
from playwright.sync_api import expect

from queueing import services as queue
from queueing.rows import announce
from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.states import Cycle
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.drawn import settle
from tests.faults.proxy import Proxy
from tests.rig import free_port

pytestmark = pytest.mark.timed

SIZES = pytest.mark.parametrize("size", [(1440, 900), (820, 1180), (390, 844)], ids=["desktop", "tablet", "phone"])
ROBOTS = pytest.mark.parametrize("which", ["mercury", "pa10"])
# what can be pressed and is in view, and where it is
NOTE = """() => { window.noted = [...document.querySelectorAll("main button, main a[href], main input, main select, main summary, main [tabindex='0']")]
  .map((e) => [e, e.getBoundingClientRect()])
  .filter(([e, b]) => e.checkVisibility() && b.width && b.bottom > 0 && b.top < innerHeight);
  window.scrolled = scrollY; return noted.length; }"""
# what of that is still there, but elsewhere
MOVED = """() => [...(scrollY === scrolled ? [] : [`the page: ${scrolled} to ${scrollY}`]), ...noted.flatMap(([e, was]) => {
  const is = e.getBoundingClientRect();
  const far = Math.max(...["x", "y", "width", "height"].map((name) => Math.abs(is[name] - was[name])));
  return e.isConnected && e.checkVisibility() && far > 0.5 ? [`${e.outerHTML.slice(0, 90)}: ${was.x},${was.y} to ${is.x},${is.y}`] : [];
})]"""

# which of these are shown and have a point in common with the first
OVERLAPS = """([first, ...others]) => {
  const a = document.querySelector(first).getBoundingClientRect();
  return others.filter((one) => [...document.querySelectorAll(one)].some((e) => {
    const b = e.getBoundingClientRect();
    return e.checkVisibility() && a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
  }));
}"""
PICTURES = ("#screen", ".model", ".map")


@pytest.fixture
def watching(portal, visitor):
    """Give somebody a page of a robot, over a line that can be cut; with `drives` they have the turn there."""
    lines = []

    def make(robot, size, drives=True):
        lines.append(Proxy(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port)))
        one = visitor(viewport=dict(zip(("width", "height"), size, strict=True)))
        one.line, one.allowed = lines[-1], ("ERR_", "WebSocket", "Failed to load")
        one.user = portal.person("ada", robot)
        if drives:
            portal.drive(one.user, robot)
        session(one, one.user)
        one.page.goto(f"http://localhost:{one.line.at[1]}{portal.robots[robot].get_absolute_url()}")
        one.page.wait_for_selector(".operating" if drives else "[data-do=join], [data-do=take]")
        expect(one.page.locator("#line-said")).not_to_be_empty(timeout=20_000)  # the connection has been judged
        expect(one.page.locator("#banner")).to_be_hidden()
        settle(one.page)
        return one

    yield make
    for line in lines:
        line.set("cut")
        line.close()


def press(page, control):
    """Press without scrolling first, as a finger does."""
    box = control.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)


@contextmanager
def still(one):
    """Do something to the page during the body of a `with` statement, by which nothing may move."""
    assert one.page.evaluate(NOTE) > 1
    yield
    settle(one.page)
    assert one.page.evaluate(MOVED) == []


@ROBOTS
@SIZES
def test_stop_and_what_is_said_of_it_move_nothing(watching, size, which):
    one = watching(which, size)
    page = one.page
    with still(one):
        press(page, page.locator("[data-command=stop]"))
        expect(page.locator("#release")).to_be_visible()
        expect(page.locator("#notice")).to_be_hidden(timeout=1000)
        expect(page.locator("#banner")).to_contain_text("not confirmed", timeout=10_000)
    one.axe("stopped")
    assert page.evaluate(OVERLAPS, ["#release", *PICTURES[: 1 if size[0] < 500 else 3], "[data-command=stop]"]) == []
    release = page.locator("[data-command=release]")
    expect(release).to_be_in_viewport(ratio=1)
    with still(one):
        press(page, release)
        expect(page.locator("#notice")).to_contain_text("Look at the newest picture")
    page.check("#checked")
    expect(page.locator("#notice")).to_be_hidden(timeout=4000)
    release.focus()
    with still(one):
        release.press("Enter")
        expect(page.locator("#release")).to_be_hidden()
    assert page.evaluate("document.activeElement.id") == "screen"


@ROBOTS
@SIZES
def test_a_refusal_and_a_lost_connection_move_nothing(watching, size, which):
    one = watching(which, size)
    page = one.page
    page.locator("[data-command=stop]").focus()
    with still(one):
        one.line.set("cut")
        expect(page.locator("#banner")).to_contain_text("Connection lost", timeout=20_000)
        press(page, page.locator("#controls .button[aria-disabled=true]").first)
        expect(page.locator("#notice")).to_contain_text("connection is lost")
    assert page.evaluate("document.activeElement !== document.body")


@ROBOTS
@SIZES
@pytest.mark.parametrize("drives", [True, False], ids=["driving", "watching"])
def test_a_fault_moves_nothing(watching, portal, size, which, drives):
    one = watching(which, size, drives)
    robot = portal.robots[which]
    with still(one):
        why = "Its line says nothing: is the robot switched on, and its cable plugged in? " * 3
        Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.FAULT, reason=why.strip())
        announce(queue.queue_of(robot))
        expect(one.page.locator("#state")).to_have_text("Faulty")
        assert one.page.inner_text("#why-state") == why.strip() or drives
        assert one.page.evaluate(OVERLAPS, ["#why-state", "#screen", "#stage"]) == []
    with still(one):
        Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.READY, reason="")
        announce(queue.queue_of(robot))
        expect(one.page.locator("#state")).not_to_have_text("Faulty")


@SIZES
def test_an_offer_moves_nothing_and_the_focus_stays_with_the_panel(watching, portal, size):
    robot = portal.robots["mercury"]
    bob = portal.person("bob", "mercury")
    turn = portal.drive(bob, "mercury")
    one = watching("mercury", size, drives=False)
    page = one.page
    page.locator("[data-do=join]").press("Enter")
    expect(page.locator("#place h2")).to_have_text("You are next")
    assert page.evaluate("document.activeElement.textContent") == "You are next"
    settle(page)
    with still(one):
        portal.end(turn)
        queue.tick(SYSTEM.now())
        expect(page.locator("#place h2")).to_have_text("It is your turn")
    assert page.evaluate("document.activeElement.textContent") == "It is your turn"
    page.locator("#place [data-do=accept]").press("Enter")
    expect(page.locator("#robot.operating")).to_be_attached()
    page.locator("[data-command=stop]").focus()
    portal.end(queue.open_turn(robot))
    expect(page.locator("#place h2").first).to_have_text("Your turn is over")
    assert page.evaluate("document.activeElement.textContent") == "Your turn is over"


@ROBOTS
@SIZES
def test_the_list_of_keys_moves_nothing_and_hides_no_picture(watching, size, which):
    one = watching(which, size)
    page = one.page
    page.locator("#screen").focus()
    with still(one):
        page.keyboard.press("?")
        expect(page.locator("#keys")).to_be_visible()
    expect(page.locator("#keys")).to_be_in_viewport(ratio=0.9)
    one.axe("the list of keys")
    for share in (0, 0.5):
        page.evaluate("(share) => scrollTo(0, share * document.documentElement.scrollHeight)", share)
        settle(page)
        covered = page.evaluate(
            OVERLAPS, ["#keys", "#screen", "[data-command=stop]", "#place .timer", "[data-do=leave]"]
        )
        assert covered == [], share
    page.evaluate("() => scrollTo(0, 0)")
    settle(page)
    with still(one):
        page.keyboard.press("Escape")
        expect(page.locator("#keys")).to_be_hidden()
    assert page.evaluate("document.activeElement.id") == "screen"
    assert not services.stop_shown(portal_robot(which), SYSTEM.now()), "Escape closes the list, and no more"
    page.keyboard.press("?")
    page.keyboard.press("s")
    expect(page.locator("#release")).to_be_visible()
    expect(page.locator("#keys")).to_be_hidden()


@ROBOTS
@SIZES
def test_a_gamepad_and_many_people_move_nothing(watching, size, which):
    page = (one := watching(which, size)).page
    if which == "pa10":
        page.evaluate("document.getElementById('tab-position').click()")
        page.locator("#tool-jog").scroll_into_view_if_needed()
        settle(page)
    else:
        page.locator("#jog").scroll_into_view_if_needed()
        settle(page)
    with still(one):
        page.evaluate("""() => { navigator.getGamepads = () =>
          [{ id: "A pad", index: 0, mapping: "", connected: true, axes: [0, 0, 0, 0, 0, 0], buttons: [] }]; }""")
        expect(page.locator("#tool-jog:visible .hint, #jog:visible .hint")).to_contain_text(
            "only the left stick counts"
        )
    page.evaluate("() => scrollTo(0, 0)")
    settle(page)
    with still(one):
        page.evaluate(
            "() => { document.getElementById('watchers').textContent = ', with 1234 others who watch, ' + 'and more'.repeat(9); }"
        )


def portal_robot(driver):
    return Robot.objects.get(driver=driver)
