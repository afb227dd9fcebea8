"""The form after a turn, whose text is never lost, also on a slow line, and the pause after a failed test."""

import re

import pytest
from playwright.sync_api import expect

from operatorlog.models import Entry, SurveyAnswer
from queueing import services as queue
from robots.kit.clock import SYSTEM
from robots.models import Robot
from tests.conftest import wait_for
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session

LOADED = "() => [...document.querySelectorAll('.entry img, .frames img')].every((i) => i.complete && i.naturalWidth)"


def test_what_is_written_is_never_lost(portal, visitor):
    ada = portal.person("ada", "mercury")
    turn = portal.end(portal.drive(ada, "mercury"))
    one = session(visitor(), ada)
    one.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page = one.page
    page.goto(turn.get_absolute_url())
    # typed and left: it is there again
    page.fill("#text", "A watch, at half past four.")
    page.locator("input[type=radio][name^=s]").nth(3).check()
    page.locator("textarea[name^=s]").fill("to dig in winter")
    page.goto("/")
    page.goto(turn.get_absolute_url())
    expect(page.locator("#text")).to_have_value("A watch, at half past four.")
    expect(page.locator("textarea[name^=s]")).to_have_value("to dig in winter")
    expect(page.locator("input[type=radio][name^=s]").nth(3)).to_be_checked()
    # refused by the server: nothing is lost, nothing is saved
    page.evaluate(
        "() => { const t = document.getElementById('text'); t.removeAttribute('maxlength'); t.value = 'y'.repeat(2001); }"
    )
    page.click("main form.form button")
    expect(page.locator("main [role=alert]")).to_contain_text("at most 2000 characters")
    assert len(page.input_value("#text")) == 2001
    expect(page.locator("textarea[name^=s]")).to_have_value("to dig in winter")
    one.allowed = ("422",)
    assert not Entry.objects.exists()
    page.fill("#text", "A watch.")
    page.click("main form.form button")
    expect(page.locator(".messages")).to_contain_text("your answers are kept")
    assert Entry.objects.get().text == "A watch."
    assert Entry.objects.get().frame == turn.grant.frames.first(), "the last picture was chosen"
    assert SurveyAnswer.objects.count() == 2
    # what came of it is shared from the page that says thanks
    page.get_by_role("button", name="Copy a link to this turn").click()
    expect(page.locator("#share-said")).to_have_text("The link was copied.")
    other = visitor().page
    other.goto(page.evaluate("navigator.clipboard.readText()"))
    expect(other.locator(".entry")).to_contain_text("A watch.")
    page.wait_for_function("() => !Object.keys(localStorage).some((k) => k.startsWith('draft'))")  # its script has run
    page.fill("#find", "a watch")  # what one has found is reported later, too, and once
    page.fill("#find_x", "12")
    page.fill("#find_y", "41.5")
    page.goto("/")
    page.goto(turn.get_absolute_url())
    expect(page.locator("#find")).to_have_value("a watch")
    page.click("main form.form button")
    expect(page.get_by_text("a watch: waits for a moderator")).to_be_visible()
    expect(page.locator("#find")).to_have_value("")
    page.wait_for_function("() => !Object.keys(localStorage).some((k) => k.startsWith('draft'))")
    page.wait_for_function(LOADED)
    shown = page.locator(".entry img").evaluate(
        "(i) => [i.clientWidth / i.clientHeight, i.naturalWidth / i.naturalHeight]"
    )
    assert shown[0] == pytest.approx(shown[1], rel=0.02)
    for ratio in page.locator(".frames img").evaluate_all(
        "(all) => all.map((i) => i.clientWidth / i.clientHeight * i.naturalHeight / i.naturalWidth)"
    ):
        assert ratio == pytest.approx(1, rel=0.02)


@pytest.mark.timed
def test_without_scripts_the_pause_is_a_sentence(portal, visitor):
    from accounts.models import Attempt, OrientationRead
    from accounts.services import load_bank

    eve = portal.person("eve")
    load_bank(portal.robot)
    OrientationRead.objects.create(user=eve, robot=portal.robot, at=SYSTEM.now())
    Attempt.objects.create(  # the first failure costs no pause
        user=eve, robot=portal.robot, drawn=[], started_at=SYSTEM.now(), finished_at=SYSTEM.now(), passed=False
    )
    one = session(visitor(java_script_enabled=False), eve)
    page = one.page
    page.goto("/robots/mercury/clearance/")
    for group in page.locator("main fieldset").all():
        group.locator("input").last.check()
    page.click("main form button")
    expect(page.locator("main")).to_contain_text(re.compile(r"You can try again in \d+ seconds?"))
    expect(page.locator("a[data-pause]")).to_have_text("Try again")


def test_what_is_written_before_the_script_has_come_is_a_draft_too(portal, visitor):
    ada = portal.person("ada", "mercury")
    turn = portal.drive(ada, "mercury")
    queue.leave(Robot.objects.get(slug="mercury"), ada, SYSTEM.now())
    one = session(visitor(), ada)
    page, held = one.page, []
    page.goto(turn.get_absolute_url())
    page.fill("#text", "An older draft.")
    page.locator("textarea[name^=s]").fill("to dig in winter")
    page.route(re.compile(r"/turn_form-[\w-]+\.js"), lambda route: held.append(route))
    page.goto(turn.get_absolute_url(), wait_until="commit")
    page.fill("#text", "A watch, at half past four.")
    wait_for(lambda: page.wait_for_timeout(0) or held, 10, "the script is asked for")
    held[0].continue_()
    expect(page.locator("textarea[name^=s]")).to_have_value("to dig in winter")
    expect(page.locator("#text")).to_have_value("A watch, at half past four.")
    page.unroute_all()
    page.goto("/")
    page.goto(turn.get_absolute_url())
    expect(page.locator("#text")).to_have_value("A watch, at half past four.")
