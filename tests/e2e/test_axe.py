"""axe finds nothing on any page, in two widths and both colour schemes."""

import pytest
from playwright.sync_api import expect

from accounts.models import User
from operatorlog import services as log
from operatorlog.models import Entry, Visibility
from queueing import services as queue
from queueing.models import Ticket
from queueing.services import Asker, ask
from robots.kit.clock import SYSTEM
from tests.conftest import at_length
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.drawn import size
from tests.e2e.roaming import MAP, RING
from tests.e2e.test_layout import OVER, PUBLIC, WIDTHS
from tests.services.in_use import job_done, running

WIDE, NARROW = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
LIGHT, DARK = {"viewport": WIDE, "color_scheme": "light"}, {"viewport": NARROW, "color_scheme": "dark"}
OTHERS = [
    at_length({"viewport": WIDE, "color_scheme": "dark"}),
    at_length({"viewport": NARROW, "color_scheme": "light"}),
]
DOORS = ["/accounts/login/", "/accounts/signup/", "/accounts/password/reset/", "/accounts/password/reset/done/", "/accounts/confirm-email/"]  # fmt: skip
OTHER_LOOKS = [other.values[0] for other in OTHERS]
OF_THE_RAT = ["/robots/irat/", "/robots/irat/jobs/", "/robots/irat/statistics/", "/robots/irat/recordings/"]
GOAL = {"map": MAP, "x": RING[15][0], "y": RING[15][1]}
OWN = ["/me/", "/accounts/email/", "/accounts/password/change/", "/accounts/logout/", "/robots/mercury/orientation/"]


def looked_at(one, addresses, *looks, over=OVER):
    """Let axe look at each page in these looks; nothing may stick out of it, however wide it is."""
    for address in addresses:
        one.page.goto(address)
        if one.page.locator("#state").count():
            expect(one.page.locator("#state")).not_to_be_empty()  # it has been told of its robot
        seen(one, *looks, over=over)


def seen(one, *looks, over=OVER):
    """Look at the page that is open."""
    for look in looks or (None,):
        if look is not None:
            one.page.emulate_media(color_scheme=look["color_scheme"])
        shown = look["viewport"] if look else one.page.viewport_size
        size(one.page, shown["width"], shown["height"])
        one.axe(str(look or one.page.viewport_size))
        assert not over or one.page.evaluate(over) == [], (one.page.url, look)
    for wide in WIDTHS if over else ():
        size(one.page, wide, 900)
        assert one.page.evaluate(over) == [], (one.page.url, wide)


def both(look):
    """Return the looks in which a page is looked at, one after the other, in the gate; at length each has a test."""
    return () if look in OTHER_LOOKS else (LIGHT, DARK)


@pytest.mark.parametrize("look", [LIGHT, *OTHERS])
def test_public_pages_and_the_doors(portal, roaming, visitor, look):
    cy = portal.person("cy", "mercury", "pa10")
    job = job_done(roaming.robot, cy, SYSTEM.now(), GOAL)  # first: a tick lets the robot begin to roam
    portal.entry(cy, "mercury", visibility=Visibility.FEATURED)
    entry = portal.entry(cy, "pa10", "w" * 300)
    one = visitor(**look)
    pages = [*PUBLIC, *DOORS, *OF_THE_RAT, entry.turn.get_absolute_url(), job.get_absolute_url()]
    looked_at(one, dict.fromkeys(pages), *both(look))
    one.allowed = ("404",)
    looked_at(one, ["/nothing/"], *both(look))


@pytest.mark.parametrize("look", [LIGHT, *OTHERS])
def test_a_persons_place_from_the_queue_to_the_end_of_the_turn(portal, visitor, look):
    """On the robot's page, and in the bar on another page."""
    ada, bob = portal.person("ada", "mercury"), portal.person("bob", "mercury")
    turn = portal.drive(bob, "mercury")
    one = session(visitor(**look), ada)
    page = one.page
    pages = [portal.robot.get_absolute_url(), "/log/"]
    page.goto(pages[0])
    page.click("[data-do=join]")
    expect(page.locator("#place")).to_contain_text("You are next")
    looked_at(one, pages, *both(look))
    portal.end(turn)
    portal.serve()
    expect(page.locator("#turnbar")).to_contain_text("It is your turn on Mercury")
    looked_at(one, pages, *both(look))
    page.get_by_role("button", name="Take control").click()
    page.wait_for_selector(".operating")
    seen(one, *both(look))
    one.follow_menu("log")
    expect(page.locator("#turnbar")).to_contain_text("Leave in the middle of your turn?")
    seen(one, *both(look))
    page.get_by_role("button", name="Stay").click()
    page.locator("#screen").press("Escape")
    expect(page.locator("#release")).to_be_visible()
    seen(one, *both(look))
    page.locator("#place [data-do=leave]").click()  # asks whether the turn is to end
    seen(one, *both(look))
    driven = queue.open_turn(portal.robot)
    portal.end(driven)
    expect(page.locator("#place")).to_contain_text("Your turn is over")
    looked_at(one, pages, *both(look))


@pytest.mark.parametrize("look", [LIGHT, *OTHERS])
def test_a_jobs_page_in_each_state(roaming, visitor, look):
    ada = User.objects.create_user("ada", "ada@example.org", "correct horse 42")
    one = session(visitor(**look), ada)
    job = ask(roaming.robot, Asker(user=ada), "goal", GOAL, SYSTEM.now())
    looked_at(one, [job.get_absolute_url(), "/robots/irat/jobs/"], *both(look))
    running(job, SYSTEM.now(), progress={"text": "half way", "share": 0.5})
    looked_at(one, [job.get_absolute_url()], *both(look))
    one.page.get_by_role("button", name="Cancel this job").click()
    expect(one.page.get_by_role("status").first).not_to_contain_text("Running")
    seen(one, *both(look))


@pytest.mark.parametrize("look", [DARK, at_length(LIGHT), *OTHERS])
def test_a_turns_page_in_each_state(portal, visitor, look):
    ada = portal.person("ada", "mercury", "pa10")
    one = session(visitor(**look), ada)
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


@pytest.mark.parametrize("look", [LIGHT, at_length(DARK), *OTHERS])
def test_the_admins_pages(portal, visitor, look):
    from accounts.services import load_bank

    root = portal.person("root", is_staff=True, is_superuser=True)
    cy = portal.person("cy", "mercury", "pa10")
    entry = portal.entry(cy, "mercury")
    response = log.answer_survey(entry.turn, cy, {1: "4"}, SYSTEM.now())
    load_bank(portal.robot)
    one = session(visitor(**look), root)
    arm, sand = portal.robots["pa10"].pk, portal.robots["mercury"].pk
    ticket = Ticket.objects.first().pk
    changed = [
        f"robots/robot/{sand}", f"robots/robot/{arm}", f"operatorlog/entry/{entry.pk}", f"queueing/ticket/{ticket}",
        f"operatorlog/surveyresponse/{response.pk}", "accounts/question/1", "queueing/queue/1",
    ]  # fmt: skip
    looked_at(one, [f"/admin/{place}/change/" for place in changed], over="")
    one.page.goto(f"/admin/robots/robot/{arm}/change/")
    one.page.click("text=Add a box")
    one.axe("the box editor")
    one.page.goto("/admin/operatorlog/entry/")
    looked_at(one, ["/admin/", "/admin/operatorlog/entry/", "/admin/operatorlog/surveyquestion/"], over="")
    looked_at(one, ["/survey/results/"])
