"""Somebody without an account tries a simulator, and goes on to the robot. Rows stand for it."""

from datetime import timedelta

import pytest
from playwright.sync_api import expect

from queueing.models import Turn
from robots.kit.clock import SYSTEM
from robots.models import Lease, Robot
from robots.services import twin_of
from robots.states import Cycle
from tests.e2e.newcomer import Newcomer

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}


@pytest.fixture
def portal(bare):
    twin = twin_of(bare.robot)
    Lease.objects.create(robot=twin, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
    Robot.objects.filter(pk=twin.pk).update(cycle=Cycle.READY)
    return bare


@pytest.mark.parametrize("look", [{}, PHONE], ids=["mouse", "finger"])
def test_a_guest_tries_a_simulator_with_two_presses_and_goes_on_to_the_robot(portal, visitor, look):
    one = visitor(**look)
    new, page = Newcomer(one, "has_touch" in look), one.page
    page.goto("/")
    new.press("main a >> text=Try a simulator of Mercury first")
    page.wait_for_url("**/robots/mercury-practice/")
    expect(page.locator(".robot-head")).to_contain_text("Simulated")
    new.press("[data-do=practise]")
    portal.serve()
    expect(page.locator("#place")).to_contain_text("You practise")
    assert new.presses == 2
    turn = Turn.objects.get()
    assert turn.user.guest
    portal.end(turn)
    expect(page.locator("#place")).to_contain_text("Next: Mercury")
    expect(page.locator("#place")).not_to_contain_text("fair share")
    new.press("#place a >> text=Drive Mercury")
    page.wait_for_url("**/accounts/signup/**")
    expect(page.locator("nav")).not_to_contain_text("guest-")
    show = page.locator("text=Show the password")
    page.fill("[name=password1]", "correct horse 42")
    show.click()
    expect(page.locator("[name=password1]")).to_have_attribute("type", "text")
    show.click()
    expect(page.locator("[name=password1]")).to_have_attribute("type", "password")
