"""The arm follows the ghost while a control is held: who may, what it does, and each way in which the page loses the hand."""

import math
import time

import pytest
from playwright.sync_api import expect

from accounts.models import Clearance
from robots.kit.clock import SYSTEM
from robots.models import Command
from tests.conftest import wait_for
from tests.e2e.test_held import GAMEPAD, INJECTED, rest
from tests.e2e.test_scene import grip, tool
from tests.faults.controls import LOST
from tests.faults.proxy import Proxy
from tests.rig import free_port

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed
MUSEUM_ARM = pytest.mark.parametrize("which", ["pa10"], indirect=True)
BOTH_ARMS = pytest.mark.parametrize("which", ["pa10", "puma"], indirect=True)

RESTS_S = 0.5
STANDS_STILL = "() => { const end = performance.now() + 1500; while (performance.now() < end); }"
HOLD, ARMED = "#follow-hold", "#follow-on"


@pytest.fixture
def operator(visitor):
    def make(level=2, **options):
        person = visitor(**options)
        person.page.context.add_init_script(GAMEPAD)
        person.cleared("ada", None)
        if level > 1:
            Clearance.objects.create(user=person.user, robot=person.portal.robot, level=level, granted_at=SYSTEM.now())
        person.page.goto(f"/robots/{person.portal.robot.slug}/")
        person.take_turn()
        expect(person.page.locator("#ghost-list")).to_contain_text("The ghost is at the arm", timeout=20_000)
        return person

    return make


def hold(ada):
    """Press the button that lets the arm follow, with the mouse."""
    page = ada.page
    button = page.locator(HOLD)
    expect(button).to_have_attribute("aria-disabled", "false")
    button.scroll_into_view_if_needed()
    box = button.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()


def holds(ada):
    return ada.page.locator(f"{HOLD}.held").count() == 1


def follow(ada, portal, steps=4, then=lambda: None):
    """Hold, move the ghost to the left by keys until the arm has come after it, and do what is to be done meanwhile.

    A page that stalled has lost the hand, which the owner says: it is taken again.
    """
    for _ in range(5):
        before = tool(portal)[1]
        hold(ada)
        for _ in range(steps):
            ada.page.keyboard.press("ArrowLeft")
            ada.page.wait_for_timeout(60)
        came = by(lambda at=before: tool(portal)[1] - at > 0.004 * steps or not holds(ada), ada)
        then()
        if came and holds(ada) and tool(portal)[1] - before > 0.004 * steps:
            return before
        ada.page.mouse.up()
        wait_for(lambda: newest().final, 20, "the end of the command")
        assert LOST in newest().reason, newest().reason
    raise AssertionError(f"the arm did not follow: {ada.page.inner_text('#ladder')}")


def by(done, ada, within_s=10):
    end = time.monotonic() + within_s
    while not done() and time.monotonic() < end:
        ada.page.wait_for_timeout(20)
    return done()


def newest():
    return Command.objects.order_by("-pk")[0]


@MUSEUM_ARM
def test_who_has_no_clearance_for_it_is_told_so_and_sends_nothing(transactional_db, portal, operator):
    ada = operator(level=1)
    page = ada.page
    expect(page.locator(ARMED)).to_have_attribute("aria-disabled", "true")
    expect(page.locator("#follow-level")).to_contain_text("clearance of a higher level")
    page.locator(ARMED).dispatch_event("click")
    expect(page.locator("#notice")).to_contain_text("clearance of a higher level")
    assert not page.is_checked(ARMED)
    expect(page.locator(HOLD)).to_be_hidden()
    assert not Command.objects.exists()
    ada.axe("the scene, without the clearance to follow")


@BOTH_ARMS
def test_it_follows_while_the_button_is_held_and_rests_when_it_is_released(transactional_db, portal, operator):
    ada = operator()
    page = ada.page
    expect(page.locator(HOLD)).to_have_attribute("aria-disabled", "true")
    page.click(HOLD, force=True)
    expect(page.locator("#notice")).to_contain_text("Tick the box above first")
    assert not Command.objects.exists(), "nothing moves before somebody has said that it may"
    page.check(ARMED)
    expect(page.locator("#follow-said")).to_contain_text("From now on the arm follows the ghost while you hold it")
    # the ghost was put elsewhere: the arm does not go there, because the hand takes it where the arm is
    page.focus("#ghost-handle")
    for _ in range(8):
        page.keyboard.press("ArrowRight")
    right = tool(portal)[1]

    def full_screen():
        """There and back drops no socket: keep-alives count only over the one that began the motion."""
        page.evaluate("document.documentElement.requestFullscreen()")
        page.wait_for_function("document.fullscreenElement !== null")
        page.evaluate("document.exitFullscreen()")
        page.wait_for_function("document.fullscreenElement === null")
        page.wait_for_timeout(400)

    before = follow(ada, portal, then=full_screen)
    assert before >= right - 0.001, "it has not gone where the ghost was before"
    grips = portal.sim.count("gripper")
    page.keyboard.press("c")
    assert by(lambda: portal.sim.count("gripper") == grips + 1, ada), "the gripper closes while the arm follows"
    moved = tool(portal)
    assert moved[1] - before == pytest.approx(0.02, abs=0.005)
    at = time.monotonic()
    page.mouse.up()
    assert rest(portal, at) <= RESTS_S
    assert (newest().kind, newest().result["ended"]) == ("follow", "released")
    expect(page.locator("#ghost-list")).to_contain_text("The ghost is at the arm")
    motions = portal.sim.count("motion")
    page.keyboard.press("o")
    page.wait_for_timeout(1500)
    assert portal.sim.count("gripper") == grips + 1, "and does nothing while it does not"
    assert portal.sim.count("motion") == motions, "it holds, and returns nowhere by itself"
    ada.axe("the scene of who may let the arm follow")


@MUSEUM_ARM
def test_it_follows_the_handles_that_a_mouse_drags(transactional_db, portal, operator):
    ada = operator(viewport={"width": 1440, "height": 900})
    page = ada.page
    page.check(ARMED)
    page.locator("#model canvas").scroll_into_view_if_needed(timeout=20_000)
    page.wait_for_timeout(500)
    before = tool(portal)
    x, y = grip(page)
    page.mouse.down()
    for step in range(1, 21):
        page.mouse.move(x - 2 * step, y + step)
        page.wait_for_timeout(40)
    assert by(lambda: math.dist(tool(portal)[:3], before[:3]) > 0.005, ada), page.inner_text("#ladder")
    assert holds(ada), page.inner_text("#ladder")
    at = time.monotonic()
    page.mouse.up()
    assert rest(portal, at) <= RESTS_S
    assert (newest().kind, newest().result["ended"]) == ("follow", "released")
    expect(page.locator("#ghost-list")).to_contain_text("The ghost is at the arm")


@MUSEUM_ARM
@pytest.mark.parametrize("cause", ["blur", "hidden page", "gamepad unplugged", "stood still", "key released"])
def test_each_lost_hand_rests_within_half_a_second(transactional_db, portal, operator, cause):
    ada = operator()
    page = ada.page
    page.check(ARMED)
    before = tool(portal)[1]
    for _ in range(8):  # without a graphics card a page stands still now and then
        page.focus(HOLD)
        expect(page.locator(HOLD)).to_have_attribute("aria-disabled", "false")
        if cause == "gamepad unplugged":
            page.evaluate("() => { pad.mapping = 'standard'; pad.axes = [0, 0, 0, 0]; }")
            page.wait_for_timeout(200)  # it is seen at rest
            page.evaluate("() => { pad.axes = [-1, 0, 0, 0]; pad.buttons[7] = { pressed: true }; }")
        else:
            page.keyboard.down(" ")
            for _ in range(12):
                page.keyboard.press("ArrowLeft")
        if by(lambda: tool(portal)[1] - before > 0.01, ada, 5) and not newest().final:
            break
        page.keyboard.up(" ")
        page.evaluate("() => { pad.axes = [0, 0, 0, 0]; pad.buttons[7] = { pressed: false }; }")
    assert not newest().final, page.inner_text("#ladder")
    at = time.monotonic()
    if cause == "key released":
        page.keyboard.up(" ")
    elif cause == "stood still":
        page.evaluate(STANDS_STILL)
    else:
        page.evaluate(f"() => {{ {INJECTED[cause]} }}")
    assert rest(portal, at) <= RESTS_S
    commands, where = Command.objects.count(), tool(portal)
    # the hand is still on the control, and nothing begins again by that
    page.keyboard.press("ArrowLeft")
    page.wait_for_timeout(1500)
    assert Command.objects.count() == commands
    assert tool(portal)[:3] == pytest.approx(where[:3], abs=1e-4), "it holds, and does not lurch"
    wait_for(lambda: newest().final, 20, "the end of the command")


@MUSEUM_ARM
def test_after_a_lost_line_the_arm_holds_and_follows_again_without_a_reload(transactional_db, portal, operator):
    ada = operator()
    ada.allowed += ("WebSocket", "ERR_", "Failed to load")
    page, line = ada.page, Proxy(("127.0.0.1", free_port()), ("127.0.0.1", portal.web.port))
    try:
        page.goto(f"http://localhost:{line.at[1]}/robots/{portal.robot.slug}/")
        page.wait_for_selector(".operating")
        expect(page.locator("#ghost-list")).to_contain_text("The ghost is at the arm", timeout=20_000)
        page.evaluate("window.sameDocument = true")
        page.check(ARMED)
        follow(ada, portal)
        at = time.monotonic()
        line.set("stall")
        assert rest(portal, at) <= RESTS_S
        where = tool(portal)
        page.wait_for_timeout(3000)
        page.mouse.up()
        assert tool(portal)[:3] == pytest.approx(where[:3], abs=1e-4), "it holds where it was"
        line.set("cut")
        line.set("pass")
        follow(ada, portal)
        page.mouse.up()
        wait_for(lambda: newest().final, 20, "the end of the command")
        assert page.evaluate("window.sameDocument")
    finally:
        line.close()


FEELS = """() => {
  [window.felt, window.tones] = [0, 0];
  Object.assign(pad, { mapping: "standard", axes: [0, 0, 0, 0] });
  pad.vibrationActuator = { playEffect: () => { felt++; return Promise.resolve("complete"); } };
  const make = AudioContext.prototype.createOscillator;
  AudioContext.prototype.createOscillator = function () { tones++; return make.call(this); };
}"""


@MUSEUM_ARM
def test_depth_is_felt_by_a_gamepad_and_heard_by_who_asked_for_less_motion(transactional_db, portal, operator):
    page = operator(level=1).page
    page.evaluate(FEELS)

    def touch():
        """Lower the ghost to the table by the gamepad; return what was felt and heard by that."""
        page.focus("#ghost-handle")
        page.keyboard.press("g")
        page.wait_for_timeout(200)  # the gamepad is seen at rest
        before = page.evaluate("[felt, tones]")
        page.evaluate("() => { pad.axes = [0, 0, 0, 1]; }")
        expect(page.locator("#ghost-list")).to_contain_text("would enter the table", timeout=30_000)
        page.evaluate("() => { pad.axes = [0, 0, 0, 0]; }")
        return [after - one for after, one in zip(page.evaluate("[felt, tones]"), before, strict=True)]

    felt, tones = touch()
    assert felt >= 1
    assert tones == 0, "nobody has switched the sound on"
    page.emulate_media(reduced_motion="reduce")
    assert touch() == [0, 0]
    page.locator(".more-input summary").click()
    page.check("#feel-sound")
    felt, tones = touch()
    assert felt == 0
    assert tones >= 1
    page.emulate_media(reduced_motion="no-preference")
    page.uncheck("#feel-on")
    assert touch()[0] == 0
    assert not Command.objects.exists(), "a ghost leaves the wire silent"
