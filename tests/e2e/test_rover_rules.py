"""The editor of the hall rover's rules in a real browser: a rule is refused where it stands, another is sent on patrol."""

import pytest
from playwright.sync_api import expect

from robots.kit.drivers.srv1.rules import crc_of, paper
from robots.models import Command, Lease
from tests.conftest import wait_for
from tests.e2e.drawn import size
from tests.e2e.test_layout import OVER

pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["srv1"], indirect=True)]
PEAKS = {"VS, very slow": 0.04, "S, slow": 0.08, "M, medium": 0.12, "F, fast": 0.16, "VF, very fast": 0.2}


@pytest.fixture
def operator(visitor):
    person = visitor().cleared("ada")
    person.take_turn()
    person.page.click("#hall-rules > summary")
    return person


def in_force(portal):
    return (Lease.objects.get(robot=portal.robot).state or {}).get("values", {}).get("rules")


def rule(page, infrared, sonar):
    return page.get_by_label(f"Speed if infrared is {infrared} and sonar is {sonar}", exact=True)


def test_rules_are_edited_refused_and_sent_while_it_patrols(operator, portal):
    page = operator.page
    expect(page.locator("#hall-rules-force")).to_have_text("In force: the paper's rules.")
    assert page.input_value("#hall-rules-text") == paper()
    operator.give("patrol")
    send = page.locator("[data-command=rules-send]")

    rule(page, "near", "very far").focus()
    page.keyboard.type("VF")  # by keys, as in every list
    expect(rule(page, "near", "very far")).to_have_attribute("aria-invalid", "true")
    words = "Rule 10 (infrared N, sonar VF) is too fast: 0.40 m/s takes 0.23 m to stop"
    expect(page.locator("#hall-rules-wrong")).to_contain_text(words)
    expect(send).to_have_attribute("aria-disabled", "true")
    operator.axe("a rule is refused")
    page.click("#hall-rules-paper")
    expect(page.locator("#hall-rules-wrong li")).to_have_count(0)

    page.locator("#hall-rules summary", has_text="peaks").click()
    for label, peak in reversed(PEAKS.items()):
        page.get_by_label(f"speed: peak of {label}, in m/s", exact=True).fill(str(peak))
    for label, peak in PEAKS.items():
        page.get_by_label(f"speed: peak of {label}, in m/s", exact=True).fill(str(peak))
    expect(page.locator("#hall-rules-ghost")).to_contain_text("by the set in force")
    expect(send).to_have_attribute("aria-disabled", "false")
    text = page.input_value("#hall-rules-text")
    assert "output speed m/s: VS 0.04, S 0.08, M 0.12, F 0.16, VF 0.2" in text
    send.click()
    wait_for(lambda: in_force(portal) == crc_of(text), 20, "the set is in force")
    expect(page.locator("#hall-rules-force")).to_contain_text("sent from here")
    assert Command.objects.get(kind="rules").args == {"text": text}
    assert Command.objects.get(kind="patrol", issued_by__isnull=False).state == "acknowledged", "it drives on"

    page.locator("[data-command=rules-back]").click()
    expect(page.locator("#hall-rules-force")).to_have_text("In force: the paper's rules.", timeout=20_000)


def test_two_readings_change_places_and_the_text_says_the_same(operator):
    page = operator.page
    page.select_option("[data-input='0']", "sonar")
    expect(page.locator("#hall-rules-table thead")).to_contain_text("sonar ↓ infrared →")
    page.select_option("[data-input='1']", "light")
    assert "input light %: VN 10, N 30" in page.input_value("#hall-rules-text")
    expect(page.locator("#hall-rules-wrong li").first).to_contain_text("counts from 0.15 m on")
    page.locator("#hall-rules summary", has_text="text").click()
    page.fill("#hall-rules-text", "method none")
    expect(page.locator("#hall-rules-said")).to_have_text("This is no line of a rule set: “method none”.")
    page.fill("#hall-rules-text", paper())
    expect(page.locator("#hall-rules-wrong li")).to_have_count(0)
    for width in (1280, 390):
        size(page, width, 860)
        operator.axe(f"{width} px")
        assert page.evaluate(OVER) == [], width
