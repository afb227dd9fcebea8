"""axe finds nothing on any page, in both languages, two widths and both colour schemes."""

from datetime import timedelta
from itertools import product

import pytest
from allauth.account.forms import default_token_generator
from allauth.account.models import EmailAddress, EmailConfirmationHMAC
from allauth.account.utils import user_pk_to_url_str
from playwright.sync_api import expect

from operatorlog import services as log
from operatorlog.models import Entry, Visibility
from queueing import services as queue
from queueing.services import Asker, ask, queue_of
from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Lease, RecordingState, Robot
from robots.recordings import keeping
from robots.services import twin_of
from robots.states import Cycle
from tests.conftest import at_length
from tests.e2e.bare import JOINTS, BarePortal
from tests.e2e.conftest import session
from tests.e2e.drawn import size
from tests.e2e.pages import OWN, PUBLIC, STAFF, known
from tests.e2e.recorded import recording as recording
from tests.e2e.roaming import MAP, RING, RoamingPortal
from tests.e2e.test_layout import OVER, WIDTHS
from tests.services.in_use import job_done, running

WIDE, NARROW = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
LOOKS = [{"viewport": v, "color_scheme": c} for v, c in product((WIDE, NARROW), ("light", "dark"))]
LIGHT, DARK = LOOKS[0], LOOKS[3]


def spoken(locale, *looks):
    """Return these looks in a language; a page is loaded once for all of them."""
    return [{"locale": locale, **look} for look in looks]


def named(looks):
    """Return the name of a test in these looks."""
    return "-".join([looks[0]["locale"][:2], *(f"{one['viewport']['width']}-{one['color_scheme']}" for one in looks)])


# in the gate each page in both languages, widths and schemes; at length the others of the eight, too
ENGLISH, GERMAN = spoken("en-US", LIGHT), spoken("de-DE", DARK)
REST = [spoken("en-US", *LOOKS[1:]), spoken("de-DE", *LOOKS[:3])]
EACH_LOOK = pytest.mark.parametrize("looks", [ENGLISH, GERMAN, *map(at_length, REST)], ids=named)
ROBOTS = {"mercury": JOINTS["mercury"], "pa10": JOINTS["pa10"], "puma": (0.26, 0.96, 1.48, 0.0, 0.7, 0.0), "srv1": ()}
GOAL = {"map": MAP, "x": RING[15][0], "y": RING[15][1]}


@pytest.fixture
def portal(transactional_db, redis_server, house):
    """All robots: arms and rover by rows and states, the iRat with its map, too."""
    bus.connection().flushall()
    web = house.web_process()
    made, rat = BarePortal(web, ROBOTS), RoamingPortal(web)
    made.robots["irat"] = rat.robot
    yield made
    rat.stop()
    made.stop()


def looked_at(one, addresses, looks, over=OVER):
    """Let axe look at each page in these looks; nothing may stick out of it, however wide it is."""
    for address in addresses:
        one.page.goto(address)
        if one.page.locator("#state").count():
            expect(one.page.locator("#state")).not_to_be_empty()  # it has been told of its robot
        seen(one, looks, over)


def seen(one, looks, over=OVER):
    """Look at the page that is open."""
    page = one.page
    for look in looks:
        if len(looks) > 1:
            page.emulate_media(color_scheme=look["color_scheme"])
            size(page, *look["viewport"].values())
        one.axe(named([look]))
        assert page.evaluate(over) == [], (page.url, looks)
    if over is OVER and looks is not ENGLISH:  # whose words are shorter: at length
        for wide in WIDTHS:
            size(page, wide, 900)
            assert page.evaluate(over) == [], (page.url, wide)
    if page.viewport_size != looks[0]["viewport"]:
        size(page, *looks[0]["viewport"].values())


@pytest.fixture
def job(portal):
    """A job of the iRat that is done; made before a tick lets the robot begin to roam."""
    return job_done(portal.robots["irat"], portal.person("eve"), SYSTEM.now(), GOAL)


@EACH_LOOK
def test_pages_for_everybody(portal, job, recording, visitor, looks):
    cy = portal.person("cy", "mercury", "pa10")
    portal.entry(cy, "mercury", visibility=Visibility.FEATURED)
    entry = portal.entry(cy, "pa10", "w" * 300)
    gone = keeping.begin(entry.turn.grant, "here", SYSTEM.now())
    keeping.finish(gone, RecordingState.READY, "", SYSTEM.now())  # its file is not there
    twin = twin_of(portal.robot)
    queue_of(twin)
    Lease.objects.create(robot=twin, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
    Robot.objects.filter(pk=twin.pk).update(cycle=Cycle.READY, enabled=True)
    address = EmailAddress.objects.create(user=cy, email=cy.email, primary=True)
    rows = {
        "turn": entry.turn.pk, "job": job.key, "recording": recording.key, "practice": twin.slug,
        "reset": f"{user_pk_to_url_str(cy)}-{default_token_generator.make_token(cy)}",
        "confirmation": EmailConfirmationHMAC(address).key,
    }  # fmt: skip
    one = visitor(**looks[0])
    one.allowed = ("404", "/mercury/camera/0.jpg")  # where nothing is; no camera sees now
    looked_at(one, [*known(PUBLIC, **rows).values(), gone.get_absolute_url()], looks)


def test_two_targets_of_less_than_24_px_side_by_side_are_found(portal, visitor):
    one = visitor()
    one.page.goto("/story/")
    one.axe()
    one.page.evaluate("""() => document.querySelector("main").append(...["a", "b"].map((text) => {
      const made = Object.assign(document.createElement("button"), { textContent: text });
      made.style.cssText = "all: unset; display: inline-block; width: 20px; height: 20px; color: black; background: white";
      return made;
    }))""")
    with pytest.raises(AssertionError, match="target-size"):
        one.axe()


@EACH_LOOK
def test_a_persons_place_from_the_queue_to_the_end_of_the_turn(portal, visitor, looks):
    """On the robot's page, and in the bar on another page."""
    ada, bob = portal.person("ada", "mercury"), portal.person("bob", "mercury")
    turn = portal.drive(bob, "mercury")
    one = session(visitor(**looks[0]), ada)
    page = one.page
    pages = [portal.robot.get_absolute_url(), "/log/"]
    page.goto(pages[0])
    page.click("[data-do=join]")
    expect(page.locator("#place [data-do=leave]")).to_be_visible()
    looked_at(one, pages, looks)
    portal.end(turn)
    portal.serve()
    expect(page.locator("#turnbar [data-do$=accept]")).to_be_visible()
    looked_at(one, pages, looks)
    page.locator("#turnbar [data-do$=accept]").click()
    page.wait_for_selector(".operating")
    seen(one, looks)
    one.follow_menu({"en-US": "log", "de-DE": "Logbuch"}[looks[0]["locale"]])
    expect(page.locator("#turnbar [data-do$=keep]")).to_be_visible()
    seen(one, looks)
    page.locator("#turnbar [data-do$=keep]").click()
    page.locator("#screen").press("Escape")
    expect(page.locator("#release")).to_be_visible()
    seen(one, looks)
    page.locator("#place [data-do=leave]").click()  # asks whether the turn is to end
    seen(one, looks)
    driven = queue.open_turn(portal.robot)
    portal.end(driven)
    expect(page.locator(f"#place a[href='{driven.get_absolute_url()}']")).to_be_visible()
    looked_at(one, pages, looks)


@EACH_LOOK
def test_a_jobs_page_in_each_state(portal, visitor, looks):
    ada = portal.person("ada")
    one = session(visitor(**looks[0]), ada)
    job = ask(portal.robots["irat"], Asker(user=ada), "goal", GOAL, SYSTEM.now())
    looked_at(one, [job.get_absolute_url(), "/robots/irat/jobs/"], looks)
    running(job, SYSTEM.now(), progress={"text": "half way", "share": 0.5})
    looked_at(one, [job.get_absolute_url()], looks)
    said = one.page.get_by_role("status").first
    before = said.inner_text()
    one.page.locator(".job-cancel button").click()
    expect(said).not_to_have_text(before)
    seen(one, looks)


@EACH_LOOK
def test_a_persons_own_pages_and_a_turns_page_in_each_state(portal, visitor, looks):
    ada = portal.person("ada", "mercury", "pa10")
    EmailAddress.objects.create(user=ada, email=ada.email, verified=True, primary=True)
    EmailAddress.objects.create(user=ada, email="second@example.org")
    one = session(visitor(**looks[0]), ada)
    turn = portal.drive(ada, "mercury")
    address = turn.get_absolute_url()
    looked_at(one, [address, *known(OWN, new="puma").values()], looks)  # still driving
    portal.end(turn)
    looked_at(one, [address], looks)  # nothing written
    one.page.evaluate("() => { for (const e of document.querySelectorAll('[required]')) e.required = false; }")
    one.page.click("main form.form button")  # refused: nothing was filled in
    one.axe("refused")
    one.allowed = ("422",)
    entry = log.write(turn, ada, "A watch.", turn.grant.frames.first().pk, SYSTEM.now())
    looked_at(one, [address, f"{address}?edit=1"], looks)
    log.answer_survey(turn, ada, {}, SYSTEM.now())
    Entry.objects.filter(pk=entry.pk).update(visibility=Visibility.FEATURED)
    looked_at(one, [address, f"{address}?edit=1"], looks)
    Entry.objects.filter(pk=entry.pk).update(visibility=Visibility.HIDDEN, hidden_reason="rude")
    looked_at(one, [address], looks)


@EACH_LOOK
def test_pages_of_staff(portal, visitor, looks):
    from accounts.services import load_bank

    root = portal.person("root", is_staff=True, is_superuser=True)
    cy = portal.person("cy", "mercury", "pa10")
    entry = portal.entry(cy, "mercury")
    log.answer_survey(entry.turn, cy, {1: "4"}, SYSTEM.now())
    load_bank(portal.robot)
    one = session(visitor(**looks[0]), root)
    looked_at(one, known(STAFF, robot=portal.robot.pk).values(), looks)
    one.page.goto(f"/admin/robots/robot/{portal.robots['pa10'].pk}/change/")
    one.page.click(".boxes-editor > button")
    one.axe("the box editor")
