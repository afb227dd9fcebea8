"""A phone as a controller: the same page for the same person, whose finger and turns the arm follows."""

import math

import cv2
import numpy as np
import pytest
from playwright.sync_api import expect

from accounts.models import Clearance
from robots.kit.clock import SYSTEM
from robots.models import Command
from tests.conftest import wait_for
from tests.e2e.conftest import session
from tests.e2e.test_held import FLAT
from tests.e2e.test_scene import tool

pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["pa10"], indirect=True)]

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
TURNED = """([alpha, beta, gamma]) => dispatchEvent(new DeviceOrientationEvent("deviceorientation", { alpha, beta, gamma }))"""


class Finger:
    """One finger on the touch pad."""

    def __init__(self, page):
        self.page, self.cdp = page, page.context.new_cdp_session(page)
        box = page.locator("#touch-pad").bounding_box()
        self.at = [box["x"] + box["width"] / 2, box["y"] + box["height"] * 0.8]

    def _tell(self, kind, points):
        self.cdp.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def down(self):
        self._tell("touchStart", [{"x": self.at[0], "y": self.at[1], "id": 0}])

    def move(self, right, down, steps=20):
        for _ in range(steps):
            self.at = [self.at[0] + right / steps, self.at[1] + down / steps]
            self._tell("touchMove", [{"x": self.at[0], "y": self.at[1], "id": 0}])
            self.page.wait_for_timeout(40)

    def beside(self, control):
        """Tap a control with a second finger, while this one stays where it is."""
        box, own = control.bounding_box(), {"x": self.at[0], "y": self.at[1], "id": 0}
        other = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2, "id": 1}
        self._tell("touchStart", [own, other])
        self.page.wait_for_timeout(100)
        self._tell("touchMove", [own])

    def up(self):
        self._tell("touchEnd", [])


def told_by_code(page):
    """Return the address in the code of the page, as a phone's camera reads it."""
    page.locator(".more-input summary").click()
    picture = page.locator(".page-code").screenshot()
    address, _, _ = cv2.QRCodeDetector().detectAndDecode(
        cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)
    )
    assert address.endswith("/robots/pa10/#controller"), address
    return address


@pytest.fixture
def pair(visitor):
    """A person with a turn on a wide page, and the same person's phone."""
    wide = visitor()
    phone = visitor(**PHONE)
    for one in (wide, phone):
        one.page.context.add_init_script(FLAT)
        one.allowed = ("WebGL",)
    wide.cleared("ada", None)
    Clearance.objects.create(user=wide.user, robot=wide.portal.robot, level=2, granted_at=SYSTEM.now())
    wide.page.goto(f"/robots/{wide.portal.robot.slug}/")
    wide.take_turn()
    session(phone, wide.user)
    phone.context.grant_permissions(["accelerometer", "gyroscope", "magnetometer"])  # what the person is asked for
    phone.page.goto(told_by_code(wide.page))
    phone.page.wait_for_selector(".operating")
    expect(phone.page.locator("#touch-pad")).to_be_visible()
    return wide, phone


def test_a_finger_and_the_turns_of_a_phone_move_the_arm_of_the_same_person(transactional_db, portal, pair):
    wide, phone = pair
    page = phone.page
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    expect(page.get_by_role("button", name="Stop", exact=True)).to_be_visible()
    expect(page.locator("#picture")).to_be_hidden()
    page.check("#follow-on")
    page.locator(".more-input summary").click()
    phone.axe("a phone as a controller")
    page.check("#tilt-on")
    page.evaluate("scrollTo(0, 0)")  # the pad and the buttons of the gripper are in view
    for _ in range(4):  # a page that stalled has lost the hand: it is taken again
        before = tool(portal)
        finger = Finger(page)
        finger.down()
        expect(page.locator("#follow-hold")).to_have_class("button held")
        page.evaluate(TURNED, [40, 0, 0])
        finger.move(0, -80)
        for degrees in range(41, 61):
            page.evaluate(TURNED, [degrees, 0, 0])
            page.wait_for_timeout(40)
        grips = portal.sim.count("gripper")
        finger.beside(page.locator("[data-command=close]"))
        page.wait_for_timeout(2500)
        newest = Command.objects.order_by("-pk")[0]
        finger.up()
        if newest.kind == "follow" and not newest.final:
            break
    wait_for(lambda: Command.objects.order_by("-pk")[0].final, 10, "the end")
    newest = Command.objects.order_by("-pk")[0]
    assert (newest.kind, newest.result["ended"]) == ("follow", "released")
    moved = [there - here for there, here in zip(tool(portal), before, strict=True)]
    assert portal.sim.count("gripper") == grips + 1, "a second finger closes the gripper meanwhile"
    # what a hand did while the page stalled for a quarter of a second is not done, so it may be less
    assert 0.02 < moved[0] < 0.043, "up on the pad is away from the base"
    assert abs(moved[1]) < 0.005
    turned = math.degrees(abs(math.remainder(moved[5], math.tau)))
    assert 10 < turned < 22, "the phone was turned by 20 degrees"
    expect(wide.page.locator("#ladder li").first).to_contain_text("Follow the hand")
    wide.axe("the page with the code for a phone")
    page.click("#controller-link")
    expect(page.locator("#picture")).to_be_visible()


def test_who_is_not_signed_in_on_the_phone_moves_nothing(transactional_db, portal, visitor):
    stranger = visitor(**PHONE)
    stranger.page.goto(f"/robots/{portal.robot.slug}/#controller")
    expect(stranger.page.locator("#banner")).to_be_attached()
    expect(stranger.page.locator("#touch-pad")).to_be_hidden()
    assert not Command.objects.exists()
