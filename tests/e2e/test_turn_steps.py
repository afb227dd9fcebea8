"""The pictures of a turn without a recording, one after the other; and axe on a page with commands."""

import pytest
from playwright.sync_api import expect

from robots.kit.clock import SYSTEM
from robots.models import Command
from tests.e2e.bare import portal as portal
from tests.e2e.test_axe import EACH_LOOK, looked_at


@pytest.fixture
def turn(portal):
    """A turn with three commands, of which the second has no picture, the third failed."""
    turn = portal.drive(portal.person("cy", "mercury"), "mercury")
    for number, (kind, args, state) in enumerate(
        (("move", {"x": 0.1, "y": 0.4}, "completed"), ("noop", {}, "completed"), ("air", {"seconds": 0.5}, "failed"))
    ):
        now = SYSTEM.now()
        made = Command.objects.create(
            robot=turn.robot, grant=turn.grant, client_seq=900 + number, kind=kind, args=args, epoch=1, state=state,
            reason="The nozzle is blocked." if state == "failed" else "", created_at=now, deadline=now,
            accepted_at=now, sent_at=now, ended_at=now,
        )  # fmt: skip
        if kind != "noop":
            frame = portal.picture("mercury", number, turn.grant)
            type(frame).objects.filter(pk=frame.pk).update(command=made)
    return portal.end(turn)


def test_the_pictures_are_stepped_through_by_keyboard(portal, turn, visitor):
    one = visitor(viewport={"width": 390, "height": 844})
    page = one.page
    page.goto(turn.get_absolute_url())
    stepper = page.get_by_role("region", name="The pictures one after the other")
    said, picture = page.locator("#stepper-said"), page.locator("#stepper-picture")
    expect(said).to_have_text("1 of 2: Move to 10 cm right, 2 cm down")
    first = picture.get_attribute("src")
    before, after = stepper.get_by_role("button", name="Before"), stepper.get_by_role("button", name="Next")
    after.focus()
    page.keyboard.press("Enter")
    expect(said).to_have_text("2 of 2: Blow air for 0.5 s")
    expect(after).to_be_focused()
    assert picture.get_attribute("src") != first
    assert "after: Blow air for 0.5 s" in picture.get_attribute("alt")
    page.keyboard.press("Enter")  # after the last one the first follows
    expect(said).to_contain_text("1 of 2")
    expect(picture).to_have_attribute("src", first)
    before.press("Enter")
    expect(said).to_contain_text("2 of 2")


def test_without_scripts_the_list_tells_everything(portal, turn, visitor):
    one = visitor(java_script_enabled=False)
    one.page.goto(turn.get_absolute_url())
    steps = one.page.locator(".steps > li")
    expect(steps).to_have_count(3)
    expect(steps.nth(1)).to_contain_text("no picture")
    expect(steps.nth(2)).to_contain_text("Failed: The nozzle is blocked.")
    expect(one.page.locator("#stepper")).to_be_hidden()


@EACH_LOOK
def test_axe_finds_nothing_on_it(portal, turn, visitor, looks):
    looked_at(visitor(**looks[0]), [turn.get_absolute_url()], looks)
