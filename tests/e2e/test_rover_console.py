"""The hall rover's page: a mission is composed without a connection, judged, sent, and its page tells what was found."""

import re

import pytest
from playwright.sync_api import expect

from portal.keep.seeding import add_robot
from queueing.models import Job
from robots.models import Finding
from tests.conftest import wait_for
from tests.e2e.conftest import session
from tests.e2e.drawn import blocks
from tests.e2e.small import SmallPortal

pytestmark = pytest.mark.timed

MISSION = "read\nturn 90\nphotograph\nsay Here begins the tour.\n"
WIDTH = "document.documentElement.scrollWidth"
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True, "color_scheme": "dark"}


@pytest.fixture
def portal(transactional_db, redis_server, house):
    made = SmallPortal(add_robot("srv1"), ready_s=120)
    yield made
    made.stop()


def written(page, text):
    page.fill("#program-text", text)


def test_a_mission_is_composed_offline_sent_and_found_done(portal, visitor):
    ada = visitor().cleared("ada")
    ada.allowed = ("ERR_", "WebSocket")
    page = ada.page
    page.goto("/robots/rover/")
    expect(page.locator("#readings")).to_contain_text("Battery", timeout=30_000)
    page.locator("#mission summary").click()
    blocks(page)
    ada.axe("the mission card")
    page.context.set_offline(True)
    written(page, "go 6.0 2.3\ngo 3.0 2.6\nphotograph\n")
    said = page.locator("#program-judged")
    expect(said).to_contain_text("Will not run")
    expect(said).to_contain_text("Step 2, go 3 2.6: The rover cannot stand there")
    written(page, "dance\n")
    expect(page.locator("#program-said")).to_contain_text("Line 1: there is no step")
    page.locator("#program-text").fill("go South\nturn 90\n")
    page.locator("#hall").click(position={"x": 60, "y": 60})
    assert page.locator("#program-text").input_value().startswith("go South\nturn 90\ngo "), "a click is a step"
    written(page, MISSION)
    expect(page.locator("#mission-steps tbody tr")).to_have_count(4)
    page.context.set_offline(False)
    expect(page.locator("#mission-send")).to_have_attribute("aria-disabled", "false", timeout=60_000)
    page.click("#mission-send")
    expect(page.locator("#asked")).to_have_text(re.compile("mission"), timeout=20_000)
    job = Job.objects.get()
    assert (job.kind, job.args["text"]) == ("mission", MISSION.strip())
    page.close()
    wait_for(lambda: Job.objects.get().state == "done", 120, "the mission, whose sender has gone")
    told = list(Finding.objects.order_by("number"))
    assert [one.text for one in told] == ["readings", "photograph", "Here begins the tour."]
    another = session(visitor(), job.user)
    back = another.page
    back.goto(job.get_absolute_url())
    expect(back.locator("#job")).to_contain_text("What it found")
    expect(back.locator("#job")).to_contain_text("Here begins the tour.")
    assert back.locator(".findings img").count() == 1


def test_the_page_fits_a_phone_and_the_map_turns_to_depth(portal, visitor):
    one = visitor(**PHONE)
    page = one.page
    page.goto("/robots/rover/")
    expect(page.locator("#readings")).to_contain_text("Battery", timeout=30_000)
    assert page.evaluate(WIDTH) <= 390
    one.axe("the rover on a phone")
    page.click("#deep")
    expect(page.locator("#hall-3d canvas")).to_be_visible(timeout=30_000)
    expect(page.locator("#hall")).to_be_hidden()
    page.click("#deep")
    expect(page.locator("#hall")).to_be_visible()
