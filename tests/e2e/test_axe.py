"""axe finds nothing on any page, in two widths and both colour schemes."""

import pytest

from operatorlog import services as log
from operatorlog.models import Entry, Visibility
from queueing.models import Ticket
from robots.clock import SYSTEM
from tests.conftest import at_length
from tests.e2e.conftest import session
from tests.e2e.test_layout import PUBLIC

WIDE, NARROW = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
LIGHT, DARK = {"viewport": WIDE, "color_scheme": "light"}, {"viewport": NARROW, "color_scheme": "dark"}
OTHERS = [
    at_length({"viewport": WIDE, "color_scheme": "dark"}),
    at_length({"viewport": NARROW, "color_scheme": "light"}),
]
DOORS = ["/accounts/login/", "/accounts/signup/", "/accounts/password/reset/", "/accounts/password/reset/done/", "/accounts/confirm-email/"]  # fmt: skip
OWN = ["/me/", "/accounts/email/", "/accounts/password/change/", "/accounts/logout/", "/robots/mercury/orientation/"]


@pytest.fixture
def portal(bare):
    return bare


def looked_at(one, addresses, *looks):
    """Let axe look at pages as they were opened, or at each in several looks, one after the other."""
    for address in addresses:
        one.page.goto(address)
        for look in looks or (None,):
            if look is not None:
                one.page.set_viewport_size(look["viewport"])
                one.page.emulate_media(color_scheme=look["color_scheme"])
            one.page.wait_for_timeout(250)
            one.axe(str(look or one.page.viewport_size))


@pytest.mark.gate
@pytest.mark.parametrize("look", [LIGHT, *OTHERS])
def test_public_pages_and_the_doors(portal, visitor, look):
    cy = portal.person("cy", "mercury", "pa10")
    portal.entry(cy, "mercury", visibility=Visibility.FEATURED)
    entry = portal.entry(cy, "pa10")
    one = visitor(**look)
    both = (LIGHT, DARK) if look is LIGHT else ()
    looked_at(one, dict.fromkeys([*PUBLIC, *DOORS, entry.turn.get_absolute_url()]), *both)
    one.allowed = ("404",)
    looked_at(one, ["/nothing/"])


@pytest.mark.gate
@pytest.mark.parametrize("look", [DARK, at_length(LIGHT), *OTHERS])
def test_a_turns_page_in_each_state(portal, visitor, look):
    ada = portal.person("ada", "mercury", "pa10")
    one = visitor(**look)
    session(one, ada)
    turn = portal.drive(ada, "mercury")
    address = turn.get_absolute_url()
    looked_at(one, [address, *OWN])  # still driving
    portal.end(turn)
    looked_at(one, [address])  # nothing written
    one.page.evaluate("() => { for (const e of document.querySelectorAll('[required]')) e.required = false; }")
    one.page.click("main form.form button")  # refused: nothing was filled in
    one.axe("refused")
    one.allowed = ("422",)
    entry = log.write(turn, ada, "A watch.", turn.grant.frames.first().pk, SYSTEM.now())
    looked_at(one, [address, f"{address}?edit=1"])
    log.answer_survey(turn, ada, {}, SYSTEM.now())
    Entry.objects.filter(pk=entry.pk).update(visibility=Visibility.FEATURED)
    looked_at(one, [address, f"{address}?edit=1"])
    Entry.objects.filter(pk=entry.pk).update(visibility=Visibility.HIDDEN, hidden_reason="rude")
    looked_at(one, [address])


@pytest.mark.gate
@pytest.mark.parametrize("look", [LIGHT, at_length(DARK), *OTHERS])
def test_the_admins_pages(portal, visitor, look):
    from accounts.bank import load_bank

    root = portal.person("root", is_staff=True, is_superuser=True)
    cy = portal.person("cy", "mercury", "pa10")
    entry = portal.entry(cy, "mercury")
    response = log.answer_survey(entry.turn, cy, {1: "4"}, SYSTEM.now())
    load_bank(portal.robot)
    one = visitor(**look)
    session(one, root)
    arm, sand = portal.robots["pa10"].pk, portal.robots["mercury"].pk
    ticket = Ticket.objects.first().pk
    changed = [
        f"robots/robot/{sand}", f"robots/robot/{arm}", f"operatorlog/entry/{entry.pk}", f"queueing/ticket/{ticket}",
        f"operatorlog/surveyresponse/{response.pk}", "accounts/question/1", "queueing/queue/1",
    ]  # fmt: skip
    looked_at(one, [f"/admin/{place}/change/" for place in changed])
    one.page.goto(f"/admin/robots/robot/{arm}/change/")
    one.page.click("text=Add a box")
    one.axe("the box editor")
    one.page.goto("/admin/operatorlog/entry/")
    looked_at(one, ["/admin/", "/admin/operatorlog/entry/", "/admin/operatorlog/surveyquestion/", "/survey/results/"])
