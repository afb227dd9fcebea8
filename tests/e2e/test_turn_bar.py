"""The bar on every page that tells people about their turn: its states, and its messages."""

import re
from datetime import timedelta

import pytest
from playwright.sync_api import expect

from queueing import services as queue
from queueing.models import Ticket, Turn
from robots.kit.clock import SYSTEM
from tests.conftest import at_length, wait_for
from tests.e2e.bare import portal as portal
from tests.e2e.drawn import IDLE, settle
from tests.e2e.frames import read
from tests.e2e.told_line import OWN_LINE, stopped_clock
from tests.waiting import CEILING_S

PHONE, DESKTOP = {"width": 390, "height": 844}, {"width": 1440, "height": 900}
BAR = "#turnbar"
POLL_MS = 11_000  # so long after it was opened a page without a socket has asked


@pytest.fixture
def cast(visitor):
    """Cleared people by name, each in a browser of their own."""
    return lambda name, **options: visitor(**options).cleared(name, None)


def elsewhere(one, address="/log/"):
    one.page.goto(address)
    queue.join(one.portal.robot, one.user, SYSTEM.now())  # in another tab
    if not Turn.objects.filter(ended_at=None).exists():
        one.portal.serve()
    return one.page


def miss():
    """Let the offer run out."""
    now = SYSTEM.now()
    Ticket.objects.filter(state="offered").update(offer_until=now)
    queue.tick(now + timedelta(seconds=1))


def test_an_offer_is_taken_up_from_another_page_on_a_phone(portal, cast):
    ada = cast("ada", viewport=PHONE)
    page = elsewhere(ada)
    bar = page.locator(BAR)
    expect(bar).to_contain_text("It is your turn on Mercury")
    assert page.title().startswith("▶ Your turn!")
    assert "icon-turn" in page.get_attribute("link[rel=icon]", "href")
    take = page.get_by_role("button", name="Take control")
    box = take.bounding_box()
    assert box["y"] + box["height"] <= 844
    assert box["y"] > 844 / 2, "within the thumb's reach"
    assert box["height"] >= 44
    ada.axe("offered on a phone")
    foot = page.locator(".site-foot")
    foot.scroll_into_view_if_needed()
    page.mouse.wheel(0, 9999)
    settle(page)
    end = foot.bounding_box()
    assert end["y"] + end["height"] <= bar.bounding_box()["y"] + 1, "the bar covers nothing"
    take.click()
    page.wait_for_url("**/robots/mercury/")
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))
    expect(page.locator(BAR)).to_be_hidden()
    wait_for(lambda: page.wait_for_timeout(0) or Turn.objects.get().connected, 10, "the robot's page keeps the turn")
    expect(page).to_have_title(re.compile("^● Driving"))


def test_the_page_ends_above_the_bar_that_the_server_had_drawn_as_high(portal, cast):
    ada = cast("ada", viewport={"width": 1440, "height": 400})
    portal.drive(ada.user, "mercury")
    page, bar = ada.page, ada.page.locator(BAR)
    page.goto("/log/")
    expect(bar.get_by_role("timer")).to_be_visible()
    settle(page)
    page.mouse.wheel(0, 9999)
    settle(page)
    end = page.locator(".site-foot").bounding_box()
    assert end["y"] + end["height"] <= bar.bounding_box()["y"] + 1, "the bar covers nothing"


def test_a_press_that_arrives_after_the_line_was_gone_for_a_while_leads_to_the_robot(portal, cast):
    ada, held, failed = cast("ada"), [], []
    ada.allowed = ("ERR_",)

    def hold(socket):
        """Keep what the bar asks for, as a socket does without a connection."""
        server = socket.connect_to_server()
        socket.on_message(lambda text: held.append((server, text)) if read(text)["t"] == "do" else server.send(text))

    ada.page.route_web_socket(OWN_LINE, hold)
    ada.page.route("**/me/places/", lambda route: (route.abort(), failed.append(route.request.method)))
    page = elsewhere(ada)
    take = page.get_by_role("button", name="Take control")
    take.click()
    wait_for(lambda: page.wait_for_timeout(20) or "POST" in failed, CEILING_S, "the request in place of the socket's")
    page.evaluate(IDLE)
    take.click(force=True)
    expect(page.locator(BAR)).to_contain_text("Your last press is on its way.")
    for server, text in held:
        server.send(text)
    page.wait_for_url("**/robots/mercury/")
    assert Turn.objects.get().ended_at is None


@pytest.mark.timed
def test_waiting_elsewhere_one_is_present_and_sees_the_place(portal, cast):
    ada, bob = cast("ada"), cast("bob")
    elsewhere(ada)
    expect(ada.page.locator(BAR)).to_contain_text("It is your turn")
    page = elsewhere(bob, "/status/")
    expect(page.locator(BAR)).to_contain_text("1 before you for Mercury")
    expect(page.locator(BAR)).to_contain_text("About")
    expect(page).to_have_title(re.compile(r"^\(2\) "))
    Ticket.objects.filter(user=bob.user).update(last_seen=SYSTEM.now() - timedelta(seconds=80))
    queue.leave(portal.robot, ada.user, SYSTEM.now())
    portal.serve()
    expect(page.locator(BAR)).to_contain_text("It is your turn on Mercury")
    fresh = SYSTEM.now() - timedelta(seconds=40)
    wait_for(lambda: page.wait_for_timeout(50) or Ticket.objects.get(user=bob.user).last_seen > fresh, 25, "presence")
    page.get_by_role("button", name="Not now").click()
    expect(page.locator(BAR)).to_be_hidden()


@pytest.mark.timed
@pytest.mark.parametrize("size", [PHONE, at_length(DESKTOP)], ids=["phone", "desktop"])
def test_a_missed_offer_is_said_until_dismissed_with_one_click_to_join_again(portal, cast, size):
    ada = cast("ada", viewport=size)
    page = elsewhere(ada)
    expect(page.locator(BAR)).to_contain_text("It is your turn")
    miss()
    expect(page.locator(BAR)).to_contain_text(
        re.compile(r"You missed your turn on Mercury at \d+:\d\d.*your place is gone\. It costs you nothing")
    )
    ada.axe("missed")
    page.goto("/story/")
    expect(page.locator(BAR)).to_contain_text("You missed your turn")
    page.get_by_role("button", name="Join again").click()
    portal.serve()
    expect(page.locator(BAR)).to_contain_text("It is your turn")
    miss()
    expect(page.locator(BAR)).to_contain_text("You missed your turn")
    page.get_by_role("button", name="Dismiss").click()
    expect(page.locator(BAR)).to_be_hidden()
    told = []
    page.on("websocket", lambda ws: "/ws/me/" in ws.url and ws.on("framereceived", lambda said: told.append(said)))
    page.reload()
    wait_for(lambda: page.wait_for_timeout(20) or any('"places"' in words for words in told), 10, "the places")
    page.evaluate(IDLE)
    assert page.locator(BAR).is_hidden()


@pytest.mark.timed
def test_leaving_in_mid_turn_asks_and_the_bar_leads_back(portal, cast):
    ada = cast("ada", viewport=PHONE)
    page = ada.page
    page.goto("/robots/mercury/")
    page.click("[data-do=take]")
    portal.serve()
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))
    ada.follow_menu("log")
    expect(page.locator(BAR)).to_contain_text("Leave in the middle of your turn?")
    expect(page.locator(BAR)).to_contain_text("20 s")
    ada.axe("asked")
    stop = page.locator("[data-command=stop]").bounding_box()
    assert stop["y"] + stop["height"] <= page.locator(BAR).bounding_box()["y"], "the bar does not cover Stop"
    page.get_by_role("button", name="Stay").click()
    expect(page.locator(BAR)).to_be_hidden()
    assert page.url.endswith("/robots/mercury/")
    ada.follow_menu("log")
    asked = []
    page.on("dialog", lambda d: (asked.append(d.type), d.accept()))
    page.get_by_role("button", name="Leave the page").click()
    page.wait_for_url("**/log/")
    assert asked == [], "asked once, not twice"
    expect(page.locator(BAR)).to_contain_text("Go back to Mercury, or your turn ends")
    ada.axe("operating elsewhere")
    page.get_by_role("link", name="Back to Mercury").click()
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))
    assert Turn.objects.get().ended_at is None
    page.reload()
    assert asked == ["beforeunload"]
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))


@pytest.mark.timed
def test_on_the_robots_own_page_nothing_contradicts_the_offer(portal, cast):
    ada, bob = cast("ada"), cast("bob", viewport=PHONE)
    elsewhere(ada)
    expect(ada.page.locator(BAR)).to_contain_text("It is your turn")
    page = bob.page
    page.goto("/robots/mercury/")
    page.click("[data-do=join]")
    expect(page.locator("#why")).to_have_text("You wait for your turn.")
    queue.leave(portal.robot, ada.user, SYSTEM.now())
    portal.serve()
    expect(page.locator("#why")).to_have_text("It is your turn: take control to begin.")
    assert "not your turn" not in page.inner_text("main").lower()
    take = page.locator(BAR).get_by_role("button", name="Take control")
    expect(take).to_be_in_viewport(ratio=1)
    bob.axe("offered on the robot's page")
    take.click()
    expect(page.locator("#robot")).to_have_class(re.compile("operating"))
    expect(page.locator(BAR)).to_be_hidden()


@pytest.mark.timed
def test_permission_to_notify_is_asked_by_a_button_only_and_used_when_one_looks_elsewhere(portal, cast):
    ada, bob = cast("ada"), cast("bob")
    elsewhere(ada)
    expect(ada.page.locator(BAR)).to_contain_text("It is your turn")
    bob.context.add_init_script("""
      window.asked = 0; window.noted = [];
      window.Notification = class { constructor(title, more) { noted.push(title); } close() {}
        static permission = "default";
        static requestPermission() { asked += 1; Notification.permission = "granted"; return Promise.resolve("granted"); } };
      Object.defineProperty(document, "hidden", { value: true });
    """)
    page = elsewhere(bob)
    tell = page.get_by_role("button", name="Tell me when it is my turn")
    expect(tell).to_be_visible()
    assert page.evaluate("asked") == 0
    expect(tell).to_have_attribute("aria-pressed", "false")
    tell.click()
    expect(tell).to_have_attribute("aria-pressed", "true")
    assert page.evaluate("asked") == 1
    expect(page.locator(BAR)).to_contain_text("This browser will notify you while a page of the portal is open.")
    sound = page.get_by_role("button", name="Sound")
    expect(sound).to_have_attribute("aria-pressed", "true")
    sound.click()
    expect(sound).to_have_attribute("aria-pressed", "false")
    bob.axe("waiting")
    queue.leave(portal.robot, ada.user, SYSTEM.now())
    portal.serve()
    wait_for(lambda: page.wait_for_timeout(50) or page.evaluate("noted"), 15, "the notification")
    assert page.evaluate("noted") == ["It is your turn on Mercury"]


@pytest.mark.timed
def test_without_the_socket_the_page_asks_by_itself(portal, cast):
    ada = cast("ada")
    ada.allowed = ("WebSocket", "ERR_")
    ada.context.add_init_script("""
      const Real = window.WebSocket;
      window.WebSocket = function (url, ...rest) { return new Real(url.replace("/ws/me/", "/ws/none/"), ...rest); };
      Object.assign(window.WebSocket, { OPEN: 1 });
    """)
    stopped_clock(ada.page)
    page = elsewhere(ada)
    page.clock.run_for(POLL_MS)
    expect(page.locator(BAR)).to_contain_text("It is your turn")
    page.get_by_role("button", name="Take control").click()
    page.wait_for_url("**/robots/mercury/")


@pytest.mark.timed
def test_without_scripts_a_line_of_the_page_leads_to_the_robot(portal, cast):
    ada = cast("ada", java_script_enabled=False)
    queue.join(portal.robot, ada.user, SYSTEM.now())
    portal.serve()
    ada.page.goto("/log/")
    expect(ada.page.locator(BAR)).to_contain_text("It is your turn on Mercury.")
    ada.page.get_by_role("button", name="Take control").click()
    ada.page.wait_for_url("**/robots/mercury/")
    assert Turn.objects.get().ended_at is None


@pytest.mark.timed
def test_who_is_not_signed_in_opens_no_socket(portal, visitor):
    one, ada = visitor(), visitor().cleared("ada", None)
    opened = {one: [], ada: []}
    for who, urls in opened.items():
        who.page.on("websocket", lambda ws, urls=urls: urls.append(ws.url))
        who.page.goto("/log/")
        who.page.evaluate(IDLE)
    wait_for(lambda: ada.page.wait_for_timeout(20) or opened[ada], 10, "who is signed in opens one")
    one.page.evaluate(IDLE)
    assert ["/ws/me/" in url for url in opened[ada]] == [True], "by now whoever opens one has"
    assert opened[one] == []
    assert one.page.locator(BAR).count() == 0
