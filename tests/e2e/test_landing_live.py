"""The landing page tells what happens while it is open."""

import pytest
from playwright.sync_api import expect

from queueing.rows import announce
from robots.models import Robot
from robots.states import Cycle
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session


def test_pictures_of_the_last_turn_follow_each_other_until_somebody_drives(portal, visitor):
    ada = portal.person("ada", "mercury")
    portal.end(portal.drive(ada, "mercury"))
    page = visitor().page
    page.goto("/")
    lead = page.locator(".lead[data-live=mercury]")
    picture = lead.locator("img")
    expect(lead).to_contain_text("Pictures of the last turn")
    first = picture.get_attribute("src")
    expect(picture).not_to_have_attribute("src", first)
    expect(picture).to_have_attribute("src", first)  # and it begins again
    page.evaluate("window.stays = true")
    portal.drive(ada, "mercury")
    expect(lead.locator(".drives")).to_have_text("ada drives")
    expect(lead).not_to_have_attribute("data-loop", "")
    expect(lead).to_have_attribute("data-state", "operating")
    assert page.evaluate("window.stays"), "without a reload"


def test_who_drives_is_told_no_wait_of_that_robot(portal, visitor):
    ada = portal.person("ada", "mercury")
    page = session(visitor(), ada).page
    page.goto("/")
    wait = page.locator("[data-live=mercury] .wait")
    expect(wait).to_have_text("Free now")
    portal.drive(ada, "mercury")
    expect(wait).to_be_empty()
    page.reload()
    expect(page.locator("[data-live=mercury] .drives")).to_have_text("ada drives")
    expect(wait).to_be_empty()
    expect(page.locator("[data-live=museum-arm] .wait")).to_have_text("Free now")


def test_a_card_says_when_its_robot_is_locked_out(portal, visitor):
    page = visitor().page
    page.goto("/")
    card = page.locator("[data-live=museum-arm]")
    expect(card.locator(".wait")).not_to_be_empty()
    before = card.locator(".pill").inner_text()
    Robot.objects.filter(slug="museum-arm").update(cycle=Cycle.LOCKED_OUT, reason="A hose is loose.")
    announce(portal.robots["pa10"].queue_link.queue)
    expect(card.locator(".pill")).not_to_have_text(before)
    expect(card.locator(".wait")).to_be_empty()


def test_who_prefers_reduced_motion_sees_one_picture(portal, visitor):
    portal.end(portal.drive(portal.person("ada", "mercury"), "mercury"))
    calm, other = visitor(reduced_motion="reduce").page, visitor().page
    shown = []
    for page in (calm, other):
        page.goto("/")
        shown.append(page.locator(".lead img"))
    first = [one.get_attribute("src") for one in shown]
    for _ in range(2):  # there and back
        expect(shown[1]).not_to_have_attribute("src", first[1])
        expect(shown[1]).to_have_attribute("src", first[1])
    expect(shown[0]).to_have_attribute("src", first[0])
    expect(calm.locator("#pause")).to_be_hidden()
    expect(other.locator("#pause")).to_be_visible()


@pytest.mark.parametrize("locale", ["de-DE", "en-US"])
@pytest.mark.parametrize(
    "size", [(390, 844), (844, 390), (720, 450), (1280, 720)], ids=lambda size: f"{size[0]}x{size[1]}"
)
def test_the_robot_and_the_way_to_driving_are_in_the_first_view(portal, visitor, size, locale):
    ada = portal.person("ada", "mercury")
    portal.end(portal.drive(ada, "mercury"))
    page = visitor(locale=locale, viewport={"width": size[0], "height": size[1]}).page
    page.goto("/")
    for part in (".lead .thumb", ".lead .name", ".lead .pill", ".actions .primary"):
        box = page.locator(part).first.bounding_box()
        assert box["y"] + box["height"] <= size[1], (part, box)
