"""The whole way of somebody who has never been here: from the landing page to a motion, the log and the survey.

Everything is pressed where it is shown, with a mouse, a finger or by keyboard alone; what it takes is counted by the
page itself. In the gate rows stand for the robot: what its owner and housekeeping do is done by their services.
"""

import pytest
from playwright.sync_api import expect

from robots.models import Command
from tests.e2e.newcomer import (
    FOCUS,
    ByKeyboard,
    Newcomer,
    command,
    end_turn,
    get_cleared,
    sign_up,
    take_turn,
    write,
)
from tests.e2e.test_whole_way import survey  # noqa: F401 - a fixture
from tests.keystrokes import ALL_PRESSES, PRESS_S, PRESSES, WITHIN_S
from tests.waiting import CEILING_S, wait_for

WIDE, NARROW = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
DESKTOP = {"viewport": WIDE}
PHONE = {"viewport": NARROW, "has_touch": True, "is_mobile": True}
DARK_PHONE, DARK_DESKTOP = {**PHONE, "color_scheme": "dark"}, {**DESKTOP, "color_scheme": "dark"}


def stops_and_goes_on(new):
    """Press Stop, which moves nothing on the page; release it after a look."""
    page = new.page
    stop = new.find("[data-command=stop]")
    at = stop.bounding_box()
    new.press("[data-command=stop]")
    expect(page.locator("#release")).to_be_visible()
    assert stop.bounding_box() == at
    new.press("#checked")
    new.press("[data-command=release]")
    expect(page.locator("#release")).to_be_hidden()


@pytest.mark.timed
@pytest.mark.parametrize("look", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_a_newcomer_comes_to_a_motion_and_into_the_log(portal, visitor, survey, look):  # noqa: F811
    one = visitor(**look)
    new, page = Newcomer(one, "has_touch" in look), one.page
    sign_up(new)
    get_cleared(new)
    take_turn(new, "down")
    new.press("[data-command=down]")
    one.ladder()
    presses, beside, seconds = new.presses, new.beside, new.seconds
    stops_and_goes_on(new)
    end_turn(page)
    expect(page.locator("#place")).to_contain_text("You ended it")
    assert page.evaluate(FOCUS) != "BODY"
    write(new)
    print(f"{presses} presses and {seconds:.0f} s to the first motion")
    assert presses <= ALL_PRESSES
    assert presses - beside <= PRESSES
    assert seconds <= WITHIN_S


class TestOnRows:
    """The same where rows stand for the robot."""

    @pytest.fixture
    def portal(self, bare):
        return bare

    @pytest.mark.parametrize(
        ("look", "person"),
        [(DESKTOP, Newcomer), (DARK_PHONE, Newcomer), (DARK_DESKTOP, ByKeyboard)],
        ids=["mouse", "finger", "keyboard"],
    )
    def test_a_newcomer_comes_to_a_motion_and_into_the_log(self, portal, visitor, look, person):
        one = visitor(**look)
        new, page = person(one, "has_touch" in look), one.page
        sign_up(new)
        get_cleared(new)
        take_turn(new, "up", portal.serve)
        print(f"{new.presses} presses, {new.beside} of them beside, and {new.seconds:.0f} s")
        assert new.presses < ALL_PRESSES, "with the press of the motion"
        assert new.presses - new.beside < PRESSES
        assert new.seconds + PRESS_S <= WITHIN_S
        command(new, "up")
        wait_for(portal.perform, CEILING_S, "the command's row")
        expect(page.locator("#ladder li").first).to_contain_text("Done")
        assert Command.objects.get().issued_by.username == "ada"
        stops_and_goes_on(new)
        end_turn(page, new.press)
        expect(page.locator("#place")).to_contain_text("You ended it")
        assert page.evaluate(FOCUS) != "BODY"
        write(new)
