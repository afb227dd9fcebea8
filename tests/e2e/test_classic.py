"""The whole way without scripts."""

import re

import pytest
from playwright.sync_api import expect

from operatorlog.models import Entry
from queueing.models import Turn
from robots.models import Command
from tests.e2e.pages import PUBLIC, known, without
from tests.waiting import CEILING_S, wait_for


def release_leave_and_write(page):
    """Release a stop after a look, leave the turn, and write of it in the log."""
    page.check("[name=checked]")
    page.click("button[value=release]")
    expect(page.locator(".messages")).to_contain_text("released")
    page.click(".ending summary")
    page.click("button[value=leave]")
    page.click("text=Write in the operator's log")
    page.fill("#text", "Driven without a single script.")


@pytest.mark.timed
def test_the_whole_way_without_scripts(portal, visitor):
    ada = visitor(java_script_enabled=False)
    page = ada.page
    ada.sign_up("ada").get_cleared()
    page.goto("/classic/mercury/")
    token = page.url
    assert re.search(r"/classic/mercury/[\w-]{20,}/$", token)
    page.click("button[value=join]")

    def offered():
        page.wait_for_timeout(300)
        page.click("text=Update")
        return page.locator("main button[value=accept]").count()

    wait_for(offered, CEILING_S, "the offer")
    page.click("main button[value=accept]")
    expect(page.locator("main")).to_contain_text("You drive")

    # the composite image is a server-side image map in a POST form
    large = page.locator("input[name=large]")
    large.click(position={"x": 2 * 260, "y": 2 * 60})
    expect(page.locator(".messages")).to_contain_text("Move: done")
    assert page.url != token, "a motion spends it"
    page.locator("input[name=large]").click(position={"x": 2 * 126, "y": 2 * 180})
    expect(page.locator(".messages")).to_contain_text("Down: done")
    page.locator("input[name=large]").click(position={"x": 2 * 210, "y": 2 * 180})
    expect(page.locator(".messages")).to_contain_text("Air: done")
    assert portal.sim.count("burst") == 1
    page.locator("input[name=large]").click(position={"x": 2 * 110, "y": 2 * 70})
    expect(page.locator(".messages")).to_contain_text("Move: done")

    # back, reload, and the form of a page that was used: nothing moves
    commands, motions = Command.objects.count(), portal.sim.count("motion")
    used = page.locator("form:has(button[value=up])").get_attribute("action")
    page.locator("button[value=up]").click()
    expect(page.locator(".messages")).to_contain_text("Up: done")
    page.go_back()
    page.reload()
    form = page.locator("form:has(button[value=up])")
    assert form.get_attribute("action") != used, "the page shown again has a fresh token"
    secret = form.locator("[name=csrfmiddlewaretoken]").get_attribute("value")
    answer = page.request.post(used, form={"do": "down", "csrfmiddlewaretoken": secret}, headers={"Referer": page.url})
    assert "used before" in answer.text()
    assert (Command.objects.count(), portal.sim.count("motion")) == (commands + 1, motions + 1)
    page.click("text=Update")
    page.locator("button[value=down]").click()

    # a click beside the sand is refused in words
    page.locator("input[name=large]").click(position={"x": 2 * 200, "y": 2 * 155})
    expect(page.locator(".messages")).to_contain_text("off the sand")
    page.click("button[value=stop]")
    expect(page.locator("main")).to_contain_text("The robot is stopped")
    release_leave_and_write(page)
    page.click("text=Put it in the log")
    assert Entry.objects.get().text == "Driven without a single script."
    assert Turn.objects.get().classic


class TestOnRows:
    """The same where rows stand for the robot: what its owner and housekeeping do is done by their services."""

    @pytest.fixture
    def portal(self, bare):
        return bare

    def test_the_way_without_scripts_but_for_the_motions(self, portal, visitor):
        one = visitor(java_script_enabled=False)
        page = one.page
        one.sign_up("ada").get_cleared()
        portal.picture("mercury", 0)
        page.goto("/classic/mercury/")
        token = page.url
        assert re.search(r"/classic/mercury/[\w-]{20,}/$", token)
        page.click("button[value=join]")
        portal.serve()
        page.click("text=Update")
        page.click("main button[value=accept]")
        expect(page.locator("main")).to_contain_text("You drive")
        # a click in the image map beside the sand is refused in words
        page.locator("input[name=large]").click(position={"x": 2 * 200, "y": 2 * 155})
        expect(page.locator(".messages")).to_contain_text("off the sand")
        assert not Command.objects.exists()
        page.click("button[value=stop]")
        expect(page.locator("main")).to_contain_text("The robot is stopped")
        assert type(portal.robot).objects.get(pk=portal.robot.pk).stop_latched
        release_leave_and_write(page)
        page.click("main form.form button")
        expect(page.locator("main")).to_contain_text("Driven without a single script.")
        assert Entry.objects.get().text == "Driven without a single script."
        assert Turn.objects.get().classic

    def test_pages_read_without_scripts(self, portal, visitor):
        one = visitor(java_script_enabled=False)
        for address in without(known(PUBLIC), "irat", "rover", "puma", "embed"):
            assert one.page.goto(address).ok
            assert len(one.page.locator("main").inner_text()) > 30
