"""Pages with their real sockets in virtual time: what another page, thread or process does meanwhile."""

import random

from queueing import services as queue
from queueing.models import TicketState, Turn
from robots import services
from robots.models import Command
from robots.states import COMMAND_FINAL
from tests.world.delays import Delays
from tests.world.portal import EACH
from tests.world.seeds import hunt, hunts, seeds
from tests.world.web import AT_ME, AT_ROBOT, Browser, Page, Sockets

TOLD_S = 1.0  # until a page shows what has changed
KEEP_S = 0.06  # between two keep-alives of a page
STALL_S = 1.0


def busy(seed):
    return Delays(seed, share=0.3, mean_s=0.5, longest_s=1.0)


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
    portal.ready()
    sockets = Sockets(world)
    here, phone = (Browser(sockets, portal.people["ada"]) for _ in range(2))
    one, other = (browser.open(AT_ROBOT.format(portal.slug)) for browser in (here, phone))
    queue.join(portal.robot, portal.people["ada"], world.now())
    queue.tick(world.now())
    portal.until(lambda: offered(other) and one.snapshot, 10, "the offer")  # and both pages know who is signed in
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
    hunt(worlds, seed, lambda portal: signs_out(portal, 6.0), busy)


def signs_out_before_the_robots_page_is_open(portal):
    """Ada accepts an offer on a page that is not the robot's, and signs out elsewhere long before she opens that one."""
    world, dice = portal.world, random.Random(portal.world.seed)
    portal.ready()
    sockets = Sockets(world)
    here, phone = (Browser(sockets, portal.people["ada"]) for _ in range(2))
    one, other = here.open(AT_ROBOT.format(portal.slug)), phone.open(AT_ME)
    queue.join(portal.robot, portal.people["ada"], world.now())
    queue.tick(world.now())
    portal.until(lambda: shown(other) == ["offered"], 10, "the offer")
    other.say("do", what="accept", robot=portal.slug)
    portal.until(lambda: shown(other) == ["operating"], 10, "the turn")
    world.sleep(6.5 + 3.0 * dice.random())
    world.spawn(here.sign_out, "ada signs out", world.process("ada"))
    portal.until(lambda: one.code == 4401, 10, "the end of the socket")
    world.sleep(3)
    turn = Turn.objects.get()
    assert turn.ended_at is None, f"the turn ended: {turn.end_reason}"
    page = phone.open(AT_ROBOT.format(portal.slug))
    portal.until(lambda: page.snapshot and page.snapshot["me"]["can"]["drive"], 10, "the controls")
    page.close()
    world.sleep(1)
    phone.sign_out()
    portal.until(lambda: other.code == 4401, 10, "the end of the other socket")


@seeds(1, 20, 200)
def test_who_signs_out_elsewhere_keeps_the_turn_whose_page_is_not_open_yet(worlds, seed):
    hunt(worlds, seed, signs_out_before_the_robots_page_is_open, busy)


def offers(portal, times=4):
    """Ada joins on one page, and is offered the robot while another page reads her new place."""
    world, dice = portal.world, random.Random(portal.world.seed)
    portal.ready()
    sockets = Sockets(world)
    browser = Browser(sockets, portal.people["ada"])
    page = browser.open(AT_ME)
    for _ in range(times):
        portal.until(lambda: not shown(page), 10, "a page without places")
        world.sleep(dice.random())
        ticket = queue.join(portal.robot, portal.people["ada"], world.now())
        world.sleep(dice.random() * 0.03)
        queue.tick(world.now())
        ticket.refresh_from_db()
        assert ticket.state == TicketState.OFFERED
        portal.until(lambda: shown(page) == ["offered"], TOLD_S, "the offer on the page")
        page.say("do", what="leave", robot=portal.slug)


@seeds(3, 20, 200)
def test_an_offer_that_is_made_while_a_page_reads_is_told_at_once(worlds, seed):
    hunt(worlds, seed, offers, jitter)


def held(portal, page, number):
    """Hold the controls of a motion on a page for a while; return its command, and when that was told last."""
    world, dice = portal.world, random.Random(f"{number} {portal.world.seed}")
    kind, args = portal.wishes.jog((-1) ** number)
    seq = services.next_seq(services.open_grant(portal.robot))
    page.say("command", kind=kind, seq=seq, args=args)

    def keeps() -> bool:
        page.say("keep", seq=seq)
        world.sleep(KEEP_S)
        return portal.rig.moving

    portal.until(keeps, 10, "a motion")
    until = world.monotonic() + 0.2 + 0.5 * dice.random()
    while world.monotonic() < until:
        page.say("keep", seq=seq)
        last = world.monotonic()
        world.sleep(KEEP_S)
    command = Command.objects.latest("pk")
    assert command.state not in COMMAND_FINAL, f"it ended while it was held: {command.reason}"
    return command, last


def let_go(page, command):
    page.say("released", seq=command.client_seq)


def closes(page, command):
    page.close()


def stalls(page, command):
    """The page goes on to say that it holds the controls; that arrives much later."""
    page.wire.stall(STALL_S)
    for _ in range(10):
        page.say("keep", seq=command.client_seq)


ENDS = {let_go: "completed", stalls: "cancelled", closes: "completed"}


@EACH
@hunts(1, 20, 200)
def test_a_held_motion_ends_with_the_controls_of_its_page(portal):
    """A held motion ends when the page lets go, is closed, or can say nothing more; nothing brings it back."""
    portal.grant()
    sockets = Sockets(portal.world)
    browser = Browser(sockets, portal.people["ada"])
    for number, (end, state) in enumerate(ENDS.items()):
        page = browser.open(AT_ROBOT.format(portal.slug))
        portal.until(lambda page=page: page.snapshot, 5, "a snapshot")
        command, last = held(portal, page, number)
        end(page, command)
        assert portal.final(command).state == state, f"{end.__name__}: {command.state}, {command.reason}"
        portal.world.sleep(STALL_S if end is stalls else 0.3)  # what arrives by then moves nothing
        took = portal.moved_until - last
        assert took <= 0.5, f"{end.__name__}: at rest {took:.3f} s after the last keep-alive"


@EACH
@hunts(1, 20, 200)
def test_a_stop_on_a_page_holds_the_robot_and_every_page_shows_it(portal):
    """A stop that the operator presses on a page holds the robot, and every page shows it; nobody else's does."""
    portal.grant()
    sockets, path = Sockets(portal.world), AT_ROBOT.format(portal.slug)
    ada, bob = (Browser(sockets, portal.people[name]).open(path) for name in ("ada", "bob"))
    pages = (ada, bob, Page(sockets, path))
    portal.until(lambda: all(page.snapshot for page in pages), 5, "the snapshots")
    for page in pages[1:]:
        page.say("stop")
        portal.until(lambda page=page: page.answers, TOLD_S, "an answer")
        assert not page.answers[0]["ok"]
    portal.world.sleep(0.5)
    assert not portal.owner.latch.latched
    portal.move()
    portal.in_motion()
    at = portal.world.monotonic()
    ada.say("stop")
    portal.at_rest()
    took = portal.world.monotonic() - at
    assert took <= 0.3, f"at rest {took:.3f} s after the stop"
    portal.until(lambda: all(page.snapshot["stopped"] for page in pages), TOLD_S, "the stop on every page")
    portal.all_final()
    ada.say("release", checked=True)
    portal.until(lambda: not any(page.snapshot["stopped"] for page in pages), TOLD_S, "the release on every page")


def test_a_seed_is_a_run_with_sockets(worlds):
    """Neither the order of sets nor the id of an object decides: `PYTHONHASHSEED` does not matter."""
    runs = []
    for _ in range(2):
        offers(portal := worlds(7, jitter(7)), 1)
        runs.append((portal.world.history, portal.rig.journal()))
    assert runs[0] == runs[1]
