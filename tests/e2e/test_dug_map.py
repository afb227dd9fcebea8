"""What was dug and found is on Mercury's map, for who drives and who watches, and the newest burst at once."""

import re

import pytest
from playwright.sync_api import expect

from operatorlog.models import Find
from robots.kit.clock import SYSTEM
from robots.models import Command
from tests.e2e.bare import BarePortal
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.waiting import CEILING_S, wait_for

PLACE = (0.02261, 0.42017)  # m: of the nozzle, by the joints that the portal tells
SQUARES = "#schematic rect.dug"
SIDE_MM = 40
LATE_MS = 60_000  # a busy machine asks late


def dig(turn, number, place=PLACE):
    """Store that it was dug at a place."""
    now = SYSTEM.now()
    return Command.objects.create(
        robot=turn.robot, grant=turn.grant, client_seq=5000 + number, kind="air", epoch=1, state="completed",
        created_at=now, deadline=now, ended_at=now, result={"sent": dict(zip("xy", place, strict=True))},
    )  # fmt: skip


def find(turn, x, y):
    """Store a confirmed find at a place (m); return the piece."""
    piece = turn.robot.rounds.get().pieces.first()
    turn.finds.create(
        round=piece.round,
        piece=piece,
        x=x,
        y=y,
        state=Find.State.CONFIRMED,
        seen_at=SYSTEM.now(),
        reported_at=SYSTEM.now(),
    )
    return piece


@pytest.fixture
def turn(portal: BarePortal):
    return portal.drive(portal.person("ada", "mercury"), "mercury")


def opened(portal, visitor, user=None, **options):
    one = visitor(**options)
    if user:
        session(one, user)
    one.page.goto(portal.robots["mercury"].get_absolute_url())
    return one


def aim(page, x, y):
    """Choose a place of the map (mm) by its fields."""
    for field, value in zip(page.locator("#place-form input").all(), (x, y), strict=True):
        field.fill(str(value))
    page.locator("#place-form input").last.press("Enter")


def test_who_drives_reads_how_often_it_was_dug_and_the_own_burst_counts_at_once(portal, visitor, turn):
    dig(turn, 0)
    dig(turn, 1, (-0.1, 0.35))
    one = opened(portal, visitor, turn.user, viewport={"width": 1440, "height": 900})
    page = one.page
    page.wait_for_selector(".operating")
    squares, why = page.locator(SQUARES), page.locator("#why")
    expect(squares).to_have_count(2, timeout=LATE_MS)
    expect(page.locator(f"{SQUARES} title")).to_have_text(["one burst here"] * 2)
    aim(page, 1000 * PLACE[0], 1000 * PLACE[1])
    expect(why).to_have_text("Enter or “Move here” sends the arm: one burst here.")
    aim(page, 150, 500)
    expect(why).to_have_text("Enter or “Move here” sends the arm: nothing dug here yet.")
    page.locator("[data-command=air]").press("Enter")
    wait_for(lambda: page.wait_for_timeout(50) or Command.objects.filter(state="queued").exists(), CEILING_S, "a burst")
    assert portal.perform()  # without a place, so that it is counted where it is drawn
    expect(squares.locator("title").filter(has_text="about two bursts here")).to_have_count(1)
    expect(squares).to_have_count(2)
    one.axe("what was dug")


def test_who_watches_sees_where_it_was_dug_in_the_right_place(portal, visitor, turn):
    for number in range(3):
        dig(turn, number)
    find(turn, *PLACE)
    page = opened(portal, visitor, viewport={"width": 390, "height": 844}, locale="de-DE").page
    square = page.locator(SQUARES)
    expect(square).to_have_class("dug dug-2", timeout=LATE_MS)
    x, y = (float(square.get_attribute(name)) for name in "xy")
    assert x <= 1000 * PLACE[0] <= x + SIDE_MM
    assert y <= -1000 * PLACE[1] <= y + SIDE_MM
    found = page.locator("#schematic .found")
    expect(found.locator("text")).to_have_text("1")
    assert float(found.locator("circle").get_attribute("cy")) == pytest.approx(-1000 * PLACE[1])
    assert not re.search("burst", square.locator("title").text_content()), "the reader's language"
    expect(page.get_by_text("Auf der Karte:")).to_be_visible()
