"""Pages with their real sockets in virtual time: what another page, thread or process does meanwhile."""

import random

from queueing import services as queue
from queueing.models import TicketState, Turn
from tests.world.delays import Delays
from tests.world.housekeeping import Housekeeping, Web
from tests.world.seeds import hunt, seeds
from tests.world.web import AT_ME, AT_ROBOT, Browser, Sockets

TOLD_S = 1.0  # until a page shows what has changed


def busy(seed):
    return Delays(seed, share=0.15, mean_s=0.5, longest_s=1.0)


def jitter(seed):
    """Delay every third wait a little: otherwise what a thread does between two waits takes no time."""
    return Delays(seed, share=0.3, mean_s=0.01, longest_s=0.1)


def shown(page) -> list[str]:
    """Return the states of the person's places that a page shows."""
    return [one["state"] for one in page.newest["places"]["places"]] if "places" in page.newest else ["not read yet"]


def offered(page) -> bool:
    """Tell whether a robot's page shows an offer."""
    ticket = page.snapshot.get("me", {}).get("ticket")
    return ticket is not None and ticket["state"] == "offered"


def signs_out(portal, most_s):
    """Ada accepts an offer in one browser, and signs out in another one within so many seconds; she drives on."""
    world, dice = portal.world, random.Random(portal.world.seed)
    Housekeeping(world)
    Web(world)
    sockets = Sockets(world)
    here, phone = (Browser(sockets, portal.people["ada"]) for _ in range(2))
    one, other = (browser.open(AT_ROBOT.format(portal.slug)) for browser in (here, phone))
    portal.ready()
    other.say("join")
    portal.until(lambda: offered(other), 30, "the offer")
    other.say("accept")
    world.sleep(dice.random() * most_s)
    world.spawn(here.sign_out, "ada signs out", world.process("ada"))
    portal.until(lambda: one.code == 4401, 10, "the end of the socket")
    world.sleep(3)
    turn = Turn.objects.get()
    assert turn.ended_at is None, f"the turn ended: {turn.end_reason}"
    assert other.code is None
    assert other.snapshot["me"]["can"]["drive"]
    phone.sign_out()
    portal.until(lambda: other.code == 4401, 10, "the end of the other socket")
    portal.until(lambda: Turn.objects.get().end_reason == "signed out", 10, "the end of the turn")


@seeds(1, 20, 200)
def test_who_signs_out_on_one_page_keeps_the_turn_accepted_on_another(worlds, seed):
    hunt(worlds, seed, lambda portal: signs_out(portal, 0.1), jitter)


@seeds(1, 20, 200)
def test_who_signs_out_on_one_page_drives_on_in_another_on_a_busy_machine(worlds, seed):
    hunt(worlds, seed, lambda portal: signs_out(portal, 8.0), busy)


def offers(portal):
    """Ada joins on one page, and is offered the robot while another page reads her new place."""
    world, dice = portal.world, random.Random(portal.world.seed)
    portal.ready()
    sockets = Sockets(world)
    browser = Browser(sockets, portal.people["ada"])
    page = browser.open(AT_ME)
    for _ in range(4):
        portal.until(lambda: not shown(page), 10, "a page without places")
        world.sleep(dice.random())
        ticket = queue.join(portal.robot, portal.people["ada"], world.now())
        world.sleep(dice.random() * 0.03)
        queue.tick(world.now())
        ticket.refresh_from_db()
        assert ticket.state == TicketState.OFFERED
        portal.until(lambda: shown(page) == ["offered"], TOLD_S, "the offer on the page")
        page.say("do", what="leave", robot=portal.slug)


@seeds(1, 20, 200)
def test_an_offer_that_is_made_while_a_page_reads_is_told_at_once(worlds, seed):
    hunt(worlds, seed, offers, jitter)
