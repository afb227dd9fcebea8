"""One press takes control of a robot that moves by itself, and the page says so until the turn begins."""

from datetime import timedelta

import pytest
from playwright.sync_api import expect

from accounts import services
from queueing import services as queue
from queueing.models import Ticket, TicketState, Turn
from queueing.rows import announce
from robots import bus
from robots.grants import start_grant
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.states import Cycle, GrantKind
from tests.e2e.bare import BarePortal
from tests.waiting import CEILING_S, wait_for

LASTS_S = 3600
LOOKS = {
    "desktop-en": {"viewport": {"width": 1440, "height": 900}},
    "desktop-de": {"viewport": {"width": 1440, "height": 900}, "locale": "de-DE"},
    "phone-en": {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True},
    "phone-de": {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True, "locale": "de-DE"},
    "lying-de": {"viewport": {"width": 844, "height": 390}, "has_touch": True, "is_mobile": True, "locale": "de-DE"},
}


@pytest.fixture
def portal(transactional_db, redis_server, house):
    """The web process, and the rover's rows while it moves by itself."""
    bus.connection().flushall()
    made = BarePortal(house.web_process(), {"srv1": ()})
    start_grant(made.robot, GrantKind.IDLE, SYSTEM.now(), until=SYSTEM.now() + timedelta(seconds=LASTS_S))
    yield made
    made.stop()


def serve(robot):
    """Advance the queue once somebody has joined, and put the robot in order as its owner does; the offer lasts."""
    wait_for(Ticket.objects.filter(state=TicketState.WAITING).exists, CEILING_S, "somebody who waits")
    now = SYSTEM.now()
    queue.tick(now, up_since=now)
    robot.refresh_from_db()
    assert robot.cycle == Cycle.HANDOVER, "it has left what it did by itself"
    Robot.objects.update(cycle=Cycle.READY)
    robot.refresh_from_db()
    robot.grants.create(kind=GrantKind.HANDOVER, epoch=1, opened_at=now, until=now, ended_at=now)
    queue.tick(now, up_since=now)
    Ticket.objects.filter(state=TicketState.OFFERED).update(offer_until=now + timedelta(seconds=LASTS_S))
    announce(queue.queue_of(robot))


@pytest.mark.parametrize("look", LOOKS.values(), ids=LOOKS)
def test_one_press_takes_a_robot_that_moves_by_itself_and_the_page_says_that_it_asks(portal, visitor, look):
    page = visitor(**look).cleared("ada").page
    take = page.locator("[data-do=take]")
    expect(take).to_be_visible()
    at = take.bounding_box()
    take.click()
    cancel = page.locator("#place [data-do=leave]")
    expect(cancel).to_be_visible()
    wait_for(Ticket.objects.exists, CEILING_S, "a place")
    assert take.bounding_box() == at
    expect(take).to_have_attribute("aria-disabled", "true")
    expect(page.locator("#turnbar")).to_be_hidden()
    for shown in (take, cancel):
        box = shown.bounding_box()
        assert box["x"] >= 0 and box["y"] >= 0 and box["y"] + box["height"] <= page.viewport_size["height"]
    serve(portal.robot)
    expect(page.locator("#robot")).to_have_class("operating", timeout=15000)
    assert Turn.objects.get().user.username == "ada"


def test_what_is_asked_for_is_cancelled_and_can_be_asked_for_again(portal, visitor):
    page = visitor().cleared("ada").page
    page.click("[data-do=take]")
    wait_for(Ticket.objects.exists, CEILING_S, "a place")
    page.click("#place [data-do=leave]")
    wait_for(lambda: Ticket.objects.get().state == TicketState.LEFT, CEILING_S, "the place is given up")
    expect(page.locator("[data-do=take]")).to_have_attribute("aria-disabled", "false")
    expect(page.locator("#place [data-do=leave]")).to_be_hidden()


def test_the_way_goes_on_at_the_test_for_who_has_read_the_orientation(portal, visitor):
    services.load_bank(portal.robot)
    one = visitor().cleared("ada", None)
    one.user.clearances.all().delete()
    one.page.goto(portal.robot.get_absolute_url())
    place = one.page.locator("#place")
    expect(place).to_contain_text("Two steps to go")
    services.mark_read(one.user, portal.robot, SYSTEM.now())
    one.page.reload()
    expect(place).to_contain_text("One step to go")
    place.locator("a.primary").click()
    one.page.wait_for_url("**/clearance/")
    expect(one.page.locator("main form [name=then]")).to_be_visible()
