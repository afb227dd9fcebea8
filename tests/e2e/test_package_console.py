"""A robot's package that ships its own console: installed beside the portal, driven in the browser by a stranger."""

import re

import pytest
from playwright.sync_api import expect

from accounts.models import Clearance, User
from portal.keep.seeding import add_robot
from portal.run.processes import recorder_process
from queueing.models import Job
from queueing.services import Asker, ask
from robots.kit.clock import SYSTEM
from robots.models import Command, Lease, Recording
from tests.conftest import wait_for
from tests.e2e.small import SmallPortal
from tests.rig import Child

pytestmark = pytest.mark.timed

SLIDER, DIAL = "#turntable-goal", "#turntable"
STABLE = (
    "/static/farhand/v1/console.js",
    "/static/farhand/v1/roaming.js",
    "/static/farhand/v1/roaming.css",
    "/static/robots/turntable/console.js",
    "/static/robots/turntable/console.css",
)

WIDGETS = {"roaming": "GraphMap", "cells": "CellGrid", "arm": "Joints", "arm_view": "ArmView", "blocks": "Blockly"}


@pytest.fixture
def portal(transactional_db, redis_server, installed):
    made = SmallPortal(add_robot("turntable"))
    yield made
    made.stop()


def turns(state):
    return Command.objects.filter(kind="turn", state=state)


def paced(page, radians_s):
    """Make the setting, and wait until it is made."""
    known = Command.objects.filter(kind="pace").count()
    page.locator("#turntable-pace").fill(radians_s)
    page.click("[data-command=pace]")
    pace = page.locator("#ladder li", has_text="Pace")
    expect(pace).to_have_count(known + 1)
    expect(pace.first).to_have_attribute("data-state", "completed")
    expect(pace.first).to_contain_text("Done")


def turn_to(page, degrees):
    page.locator(SLIDER).evaluate(
        "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input')); }", str(degrees)
    )
    page.click("[data-command=turn]")


def test_a_stranger_drives_a_robot_by_the_console_of_its_package(portal, visitor):
    ada = visitor().sign_up("ada").get_cleared()
    page = ada.page
    for address in STABLE:
        answer = page.request.get(address)
        assert answer.ok, address
        assert answer.headers["cache-control"] == "no-cache", address
        assert answer.headers["content-type"].split(";")[0] in ("text/javascript", "text/css")
    assert page.request.get("/static/robots/turntable/console.html").status == 404, "templates are not served"
    expect(page.locator(f"{DIAL} svg")).to_be_visible()
    for module, name in WIDGETS.items():
        assert name in page.evaluate(f"async () => Object.keys(await import('/static/farhand/v1/{module}.js'))"), module
    expect(page.locator("[data-command=turn]")).to_be_hidden()  # nobody drives
    ada.take_turn()
    expect(page.locator("[data-command=turn]")).to_have_attribute("aria-disabled", "false")
    stop = page.locator("[data-command=stop]")
    expect(stop).to_have_count(1)
    assert stop.evaluate("(stop) => !stop.closest('.part')"), "Stop is in no element that the package fills"
    assert page.locator(DIAL).evaluate("(dial) => Boolean(dial.closest('.part'))")
    for width, scheme in ((1280, "light"), (390, "dark")):
        page.set_viewport_size({"width": width, "height": 844})
        page.emulate_media(color_scheme=scheme)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
        ada.axe(f"{width} {scheme}")
    turn_to(page, 90)
    expect(page.locator("#ladder li").first).to_have_attribute("data-state", "completed")
    expect(page.locator(DIAL)).to_have_attribute("data-angle", "90.0")
    expect(page.locator(DIAL)).to_have_attribute("data-trail", re.compile(r"^\d\d$"))  # its byte stream is drawn
    expect(page.locator("#turntable-warmth")).to_have_text(re.compile(r"^\d+ °C$"))  # a channel of its own
    assert Lease.objects.get(robot=portal.robot).state["joints"] == pytest.approx([1.5708], abs=1e-3)
    paced(page, "0.3")  # so that it still turns when the next setting has been made
    turn_to(page, -170)
    wait_for(lambda: page.wait_for_timeout(20) or turns("acknowledged").exists(), 10, "it turns")
    paced(page, "0.5")  # beside the motion
    assert turns("acknowledged").exists(), "it turns on"
    page.evaluate(f"document.querySelector('{DIAL}').replaceChildren()")  # a console may break its own drawing
    stop.click()
    expect(page.locator("#release")).to_be_visible()
    expect(page.locator("#suspended")).to_be_visible()  # it has idle behaviour and takes jobs
    expect(page.locator("#ladder li", has_text="Turn").first).to_have_attribute("data-state", "cancelled")
    expect(page.locator("[data-command=turn]")).to_have_attribute("aria-disabled", "true")
    assert turns("cancelled").count() == 1


def test_a_mission_of_the_package_is_a_job_and_its_idle_behaviour_yields_to_it(portal, visitor):
    watcher = visitor()
    page = watcher.page
    page.goto(f"/robots/{portal.robot.slug}/")
    expect(page.locator("#operator")).to_have_text("Nobody drives")
    wait_for(lambda: page.wait_for_timeout(50) or swaying(), 30, "the table sways while nobody asks")
    asker = visitor().cleared("ada", "/robots/{}/jobs/")
    ada = asker.user
    asker.page.fill("#tour-stops", "2")
    asker.page.get_by_role("button", name="Ask for it").click()
    expect(asker.page.locator("h1")).to_contain_text("Tour on Turntable")
    job = Job.objects.get()
    wait_for(lambda: page.wait_for_timeout(50) or Job.objects.get(pk=job.pk).ended_at, 30, "the tour's end")
    assert Job.objects.get(pk=job.pk).state == "done"
    expect(asker.page.get_by_role("status").first).to_contain_text("Done", timeout=20_000)
    tour = Command.objects.get(kind="tour")
    assert (tour.state, tour.grant.kind, tour.issued_by) == ("completed", "job", ada)
    assert Command.objects.filter(kind="sway", pk__lt=tour.pk, ended_at__lte=tour.ended_at).exists()
    expect(page.locator("#ladder")).to_contain_text("Tour")
    expect(page.locator(DIAL)).not_to_have_attribute("data-angle", "0.0")


def test_its_console_shows_a_recording_of_a_job_too(portal, visitor):
    spec = recorder_process()
    recorder = Child("recorder", list(spec.argv), **spec.env, FARHAND_RECORDING_FREE_MB="1")
    try:
        ada = User.objects.create_user("ada", "ada@example.org", "correct horse 42")
        Clearance.objects.create(user=ada, robot=portal.robot, granted_at=SYSTEM.now())
        wait_for(lambda: swaying(), 30, "the table sways while nobody asks")
        job = ask(portal.robot, Asker(user=ada), "tour", {"stops": 2}, SYSTEM.now())
        wait_for(lambda: Recording.objects.exclude(state="running").exists(), 60, "the recording")
    finally:
        recorder.kill()
    page = visitor().page
    page.goto(job.get_absolute_url())
    page.get_by_role("link", name="Replay").click()
    expect(page.locator("#replay-list")).to_contain_text("Tour")
    expect(page.locator("#replay-at")).to_be_enabled()
    page.locator("#replay-at").press("End")
    expect(page.locator(DIAL)).to_have_attribute("data-trail", re.compile(r"^\d+$"))
    expect(page.locator(DIAL)).not_to_have_attribute("data-angle", "0.0")
    expect(page.locator("#ladder li").first).to_have_attribute("data-state", "completed")
    expect(page.locator("[data-command=turn]")).to_be_hidden()


def swaying():
    return Command.objects.filter(kind="sway", state="acknowledged", grant__kind="idle").exists()
