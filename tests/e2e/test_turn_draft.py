"""The form after a turn on a slow line: what is written before its script has come is kept as a draft, too."""

import re

import pytest
from playwright.sync_api import expect

from queueing import services as queue
from robots.clock import SYSTEM
from robots.models import Robot
from tests.conftest import wait_for
from tests.e2e.bare import BarePortal
from tests.e2e.conftest import session


@pytest.fixture
def portal(transactional_db, redis_server, house):
    made = BarePortal(house.web_process())
    yield made
    made.stop()


@pytest.mark.gate
def test_what_is_written_before_the_script_has_come_is_a_draft_too(portal, visitor):
    ada = portal.person("ada", "mercury")
    turn = portal.drive(ada, "mercury")
    queue.leave(Robot.objects.get(slug="mercury"), ada, SYSTEM.now())
    one = visitor()
    session(one, ada)
    page, held = one.page, []
    page.goto(turn.get_absolute_url())
    page.fill("#text", "An older draft.")
    page.locator("textarea[name^=s]").fill("to dig in winter")
    page.route(re.compile(r"/turn-\w+\.js"), lambda route: held.append(route))
    page.goto(turn.get_absolute_url(), wait_until="commit")
    page.fill("#text", "A watch, at half past four.")
    wait_for(lambda: page.wait_for_timeout(20) or held, 10, "the script is asked for")
    held[0].continue_()
    expect(page.locator("textarea[name^=s]")).to_have_value("to dig in winter")
    expect(page.locator("#text")).to_have_value("A watch, at half past four.")
    page.unroute_all()
    page.goto("/")
    page.goto(turn.get_absolute_url())
    expect(page.locator("#text")).to_have_value("A watch, at half past four.")
