"""The rover's page without a line: what it has fetched beforehand, what comes later, and what it sends."""

import re
from datetime import timedelta
from types import SimpleNamespace

import pytest
from playwright.sync_api import expect

from portal.keep.seeding import add_robot
from queueing.models import Job
from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Lease, Robot
from robots.services import programs
from robots.states import Cycle
from tests.conftest import wait_for
from tests.e2e.drawn import blocks

pytestmark = pytest.mark.timed

LARGE = ("/floor_view-", "/mission_blocks-", "/blocks-")  # files of the 3D view and of the blocks
FETCHED = (
    "names => names.every(n => performance.getEntriesByType('resource').some(r => r.name.includes(n) && r.duration))"
)


@pytest.fixture
def portal(transactional_db, redis_server, house):
    """The web process over the rover's rows; nothing needs to move."""
    bus.connection().flushall()
    robot = add_robot("srv1")
    Lease.objects.create(robot=robot, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
    Robot.objects.update(cycle=Cycle.READY)
    return SimpleNamespace(robot=robot, url=house.web_process().url)


@pytest.fixture
def ada(visitor):
    person = visitor().cleared("ada", None)
    person.allowed = ("ERR_", "WebSocket", "blocks-", "floor_view-")
    return person


def test_the_3d_view_and_the_blocks_open_for_the_first_time_with_the_line_cut(ada):
    page = ada.page
    page.goto("/robots/rover/")
    wait_for(
        lambda: page.wait_for_timeout(50) or page.evaluate(FETCHED, LARGE), 30, "the large parts, while it is idle"
    )
    page.context.set_offline(True)
    page.click("#deep")
    expect(page.locator("#hall-3d canvas")).to_be_visible(timeout=20_000)
    page.locator("#mission summary").click()
    blocks(page)


def test_what_the_line_did_not_bring_is_said_and_comes_later(ada):
    page = ada.page
    refused = re.compile("/assets/(floor_view|mission_blocks)-")
    page.route(refused, lambda route: route.abort())
    page.goto("/robots/rover/")
    page.click("#deep")
    expect(page.locator("#notice")).to_contain_text("3D view did not come")
    expect(page.locator("#hall")).to_be_visible()
    expect(page.locator("#deep")).to_have_attribute("aria-pressed", "false")
    page.locator("#mission summary").click()
    expect(page.locator("#blocks")).to_contain_text("The blocks did not come")
    page.fill("#program-text", "go South")
    expect(page.locator("#mission-steps tbody tr")).to_have_count(1)
    ada.axe("without blocks")
    page.unroute(refused)
    page.locator("#blocks").get_by_role("button", name="Reload the page").press("Enter")
    page.wait_for_load_state()
    page.click("#deep")
    expect(page.locator("#hall-3d canvas")).to_be_visible(timeout=20_000)
    page.locator("#mission summary").click()
    blocks(page)
    expect(page.locator("#blocks .blocklyBlockCanvas", has_text="South")).to_be_visible()


def test_the_mission_that_is_sent_is_the_one_that_is_shown(ada, portal):
    page = ada.page
    saved = programs.save(portal.robot, ada.user, "Round", "go South", False, SYSTEM.now())
    page.goto("/robots/rover/")
    page.locator("#mission summary").click()
    page.select_option("#program-list", str(saved.pk))
    expect(page.locator("#mission-steps tbody tr")).to_have_count(1)
    programs.save(portal.robot, ada.user, "Round", "go East\npatrol 120", False, SYSTEM.now(), saved.pk)
    page.click("#mission-send")
    wait_for(lambda: page.wait_for_timeout(50) or Job.objects.exists(), 20, "the job")
    assert Job.objects.get().args == {"text": "go South"} and page.input_value("#program-text") == "go South"
