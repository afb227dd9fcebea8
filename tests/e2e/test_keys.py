"""By keyboard: a person changes keys, goes back after a move, chooses places again, and is asked before a large step."""

import pytest
from playwright.sync_api import expect

from robots.models import Command, Robot
from tests.e2e import bare as told
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.waiting import CEILING_S, wait_for

WIDE, PHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
MOVED = (1.2, 1.6, 0.0, 0.0)  # rad, m: elsewhere over the sand
START = (0.02261, 0.42017)  # m: where the joints are that `JOINTS` has
NEAR_M = 0.001
CHOSEN = {"x": -0.1, "y": 0.35}  # m


@pytest.fixture
def driving(portal, visitor):
    def make(robot, viewport=WIDE):
        one = visitor(viewport=viewport)
        one.user = portal.person("ada", robot)
        one.turn = portal.drive(one.user, robot)
        session(one, one.user)
        one.page.goto(portal.robots[robot].get_absolute_url())
        one.page.wait_for_selector(".operating")
        expect(one.page.locator("#why")).not_to_contain_text("not known")  # a state has come
        return one

    return make


def given(page):
    """Wait for one command; return it."""
    wait_for(lambda: page.wait_for_timeout(50) or Command.objects.exists(), CEILING_S, "a command")
    return Command.objects.get()


def change(page, use):
    """Go to the button beside a key, and press it."""
    button = page.locator(f"#keys button[aria-label*=': {use} (']")
    button.focus()
    page.keyboard.press("Enter")
    expect(button).to_have_text("Press a key")
    return button


@pytest.mark.parametrize("viewport", [WIDE, PHONE])
def test_a_person_chooses_a_key_which_counts_at_once_and_stays(driving, viewport):
    one = driving("mercury", viewport)
    page = one.page
    said = page.locator(".keys-said")
    page.locator("#screen").focus()
    page.keyboard.press("?")
    button = change(page, "up")
    page.keyboard.press("d")
    expect(said).to_have_text("D is in use: down. Choose another.")
    for key in ("s", "Enter", "ArrowUp", "Control+k"):
        page.keyboard.press(key)
        expect(button).to_have_text("Press a key")
    one.axe("a key is waited for")
    page.keyboard.press("Escape")
    expect(said).to_have_text("The keys stay as they were.")
    expect(page.locator("#keys")).to_be_visible()
    change(page, "up")
    page.keyboard.press("k")
    expect(said).to_have_text("K is the key now for: up.")
    expect(page.locator("#keys kbd[data-action=up]")).to_have_text("K")
    one.axe("a key was changed")
    page.keyboard.press("Escape")
    expect(page.locator("#keys")).to_be_hidden()
    assert not Robot.objects.get(slug="mercury").stop_latched, "no key of these stopped the robot"
    page.reload()
    page.wait_for_selector(".operating")
    expect(page.locator("#why")).not_to_contain_text("not known")
    page.locator("#screen").focus()
    page.keyboard.press("u")
    page.keyboard.press("k")
    assert given(page).kind == "up"


def test_stop_gets_one_more_key_and_keeps_its_own_and_a_reset_takes_back_what_was_chosen(driving):
    page = driving("mercury").page
    page.locator("#screen").focus()
    page.keyboard.press("?")
    change(page, "stop, while the console has the focus")
    page.keyboard.press("x")
    expect(page.locator("#keys kbd[data-action=stop]")).to_have_text("X")
    page.get_by_role("button", name="Reset all keys").press("Enter")
    expect(page.locator("#keys kbd[data-action=stop]")).to_be_hidden()
    change(page, "stop, while the console has the focus")
    page.keyboard.press("x")
    page.keyboard.press("Escape")
    page.locator("#screen").focus()
    page.keyboard.press("x")
    expect(page.locator("#release")).to_be_visible()
    page.keyboard.press("?")
    expect(page.locator("#keys")).to_be_visible()


def test_after_a_move_one_goes_back_and_chooses_its_place_again(driving, portal, monkeypatch):
    one = driving("mercury")
    page = one.page
    back, recent = page.locator("[data-command=go-back]"), page.locator("#recent button")
    expect(back).to_have_attribute(
        "data-why", "There is nothing to go back to: no move to a position has ended in this turn."
    )
    x, y = page.locator("#place-form input").all()
    x.fill("-100")
    y.fill("350")
    y.press("Enter")
    page.locator("#schematic").focus()
    page.keyboard.press("Enter")
    assert given(page).args == pytest.approx(CHOSEN)
    Command.objects.update(target={"words": "Move", "place": CHOSEN})
    monkeypatch.setitem(told.JOINTS, "mercury", MOVED)
    assert portal.perform()
    expect(back).to_have_attribute("aria-disabled", "false")
    expect(recent).to_have_text(["−100, 350 mm"])
    Command.objects.all().delete()
    page.locator("#screen").focus()
    page.keyboard.press("b")
    assert not Command.objects.exists(), "it is a target first"
    expect(page.locator("#why")).to_contain_text("sends the arm")
    one.axe("the way back")
    page.keyboard.press("Enter")
    sent = given(page).args
    assert (sent["x"], sent["y"]) == pytest.approx(START, abs=NEAR_M)
    assert portal.perform()
    Command.objects.all().delete()
    recent.press("Enter")
    expect(page.locator("#why")).to_contain_text("sends the arm")
    page.locator("[data-command=go]").press("Enter")
    assert given(page).args == pytest.approx(CHOSEN)
    portal.end(one.turn)
    expect(page.locator("#places")).to_be_hidden()


def test_an_arm_goes_back_in_joint_mode(driving, portal, monkeypatch):
    page = driving("pa10").page
    back, shoulder = page.locator("[data-command=go-back]"), page.locator("#joints input[type=number]").first
    page.locator("#tab-joint").press("Enter")
    before = shoulder.input_value()
    shoulder.fill("30")
    send = page.locator("[data-command=go-joints]")
    expect(send).to_have_attribute("aria-disabled", "false")
    send.press("Enter")
    assert given(page).kind == "joints"
    monkeypatch.setitem(told.JOINTS, "pa10", (0.52, *told.JOINTS["pa10"][1:]))
    expect(page.locator("#readings")).to_contain_text("29.8°")
    assert portal.perform()
    page.locator("#tab-position").press("Enter")
    expect(back).to_have_attribute("aria-disabled", "false")
    page.locator("#screen").focus()
    page.keyboard.press("b")
    expect(page.locator("#tab-joint")).to_have_attribute("aria-selected", "true")
    expect(shoulder).to_have_value(before)


def test_a_step_says_its_size_a_large_one_is_asked_about_once_and_a_turn_begins_with_the_usual_one(driving, portal):
    one = driving("pa10")
    page = one.page
    up, list_ = page.locator("#ghost-pad button").nth(4), page.locator("#ghost-list")
    expect(up).to_have_text("z + 5 mm")
    expect(list_).to_contain_text("Place: x, y, z")
    page.focus("#ghost-handle")
    for _ in range(3):
        page.keyboard.press("+")
    expect(up).to_have_text("z + 100 mm")
    page.keyboard.press("PageUp")
    expect(list_).to_contain_text("A step of 100 mm, 45° is large.")
    page.keyboard.press("PageUp")
    expect(list_).to_contain_text("100 mm up")
    page.keyboard.press("PageDown")
    expect(list_).to_contain_text("The ghost is at the arm")
    portal.end(one.turn)
    expect(page.locator("#robot.operating")).to_have_count(0)
    portal.drive(one.user, "pa10")
    expect(page.locator("#robot.operating")).to_have_count(1)
    expect(up).to_have_text("z + 5 mm")


def test_a_key_that_is_held_gives_its_command_once(driving, portal):
    page = driving("mercury").page
    page.locator("#screen").focus()
    page.keyboard.down("u")
    assert given(page).kind == "up"
    portal.perform()
    expect(page.locator("#last-command")).to_contain_text("Done")
    for _ in range(3):
        page.keyboard.down("u")  # as a held key does
    page.keyboard.up("u")
    page.keyboard.press("a")  # another key: refused if anything were on its way
    wait_for(lambda: page.wait_for_timeout(50) or Command.objects.count() > 1, CEILING_S, "the next command")
    assert [*Command.objects.order_by("pk").values_list("kind", flat=True)] == ["up", "air"]
