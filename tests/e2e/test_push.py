"""Web Push in the browser: the press that asks for it, the service worker, and the list on the person's page.

No push service is in reach of the tests, so the browser's own way to one is replaced; what it would deliver comes from
the browser's debugger. A Chromium without a window never lets a page notify, so the permission is replaced too, and of
a notification is tested what the worker asks the browser to show. What the portal sends: tests/services/test_push.py.
"""

import json
import re

import pytest
from playwright.sync_api import expect

from accounts.models import PushSubscription
from queueing import services as queue
from queueing.models import Ticket
from robots.kit.clock import SYSTEM
from tests.conftest import wait_for
from tests.e2e.bare import portal as portal
from tests.services.push_service import Browser

BAR, TELL = "#turnbar", "Tell me when it is my turn"
PHONE = {"width": 390, "height": 844}
PERMITTED = """
  Object.defineProperty(Notification, "permission", { get: () => "granted" });
  Notification.requestPermission = () => Promise.resolve("granted");
"""
ASKED = """() => { self.shown = [];
  self.registration.showNotification = (title, more) => Promise.resolve(self.shown.push([title, more])); }"""
# a push service as the browser has it, but for the way there; the subscription outlives the page
SERVICE = """
  const kept = (fields) => fields === null ? null : {
    endpoint: fields.endpoint, toJSON: () => ({ keys: { p256dh: fields.p256dh, auth: fields.auth } }),
    unsubscribe: () => { localStorage.removeItem("test-push"); return Promise.resolve(true); } };
  const read = () => kept(JSON.parse(localStorage.getItem("test-push")));
  PushManager.prototype.subscribe = (options) => {
    window.subscribing = options;
    localStorage.setItem("test-push", JSON.stringify(FIELDS));
    return Promise.resolve(read()); };
  PushManager.prototype.getSubscription = () => Promise.resolve(read());
"""


@pytest.fixture
def cast(visitor):
    """Cleared people by name, each in a browser of their own that may notify."""

    def made(name, **options):
        one = visitor(**options).cleared(name, None)
        one.context.add_init_script(PERMITTED)
        return one

    return made


def waits(one, address="/log/"):
    """Let somebody else have the robot, and the person wait on another page."""
    other = one.portal.person("other", "mercury")
    queue.join(one.portal.robot, other, SYSTEM.now())
    one.portal.serve()
    one.page.goto(address)
    queue.join(one.portal.robot, one.user, SYSTEM.now())
    expect(one.page.locator(BAR)).to_contain_text("before you")
    return one.page.get_by_role("button", name=TELL)


def with_service(one, browser=None):
    fields = (browser or Browser("https://push.example.org/send/a")).fields
    one.context.add_init_script(SERVICE.replace("FIELDS", json.dumps(fields)))


def test_one_press_adds_the_browser_the_state_stays_and_another_removes_it(portal, cast):
    ada = cast("ada", viewport=PHONE)
    with_service(ada)
    tell = waits(ada)
    expect(tell).to_have_attribute("aria-pressed", "false")
    assert ada.page.evaluate("window.subscribing") is None, "asked for by a press alone"
    tell.click()
    expect(ada.page.locator(BAR)).to_contain_text("also when no page of the portal is open")
    expect(tell).to_have_attribute("aria-pressed", "true")
    assert ada.page.evaluate("subscribing.userVisibleOnly")
    assert ada.page.evaluate("subscribing.applicationServerKey") == ada.page.get_attribute(BAR, "data-push")
    assert PushSubscription.objects.get().user == ada.user
    ada.axe("told")
    ada.page.reload()
    expect(tell).to_have_attribute("aria-pressed", "true")
    tell.click()
    expect(ada.page.locator(BAR)).to_contain_text("This browser notifies you no more.")
    expect(tell).to_have_attribute("aria-pressed", "false")
    assert not PushSubscription.objects.exists()
    ada.page.reload()
    expect(tell).to_have_attribute("aria-pressed", "false")


def test_a_browser_without_push_says_that_a_page_has_to_stay_open(portal, cast):
    ada = cast("ada")
    ada.context.add_init_script("delete window.PushManager")
    tell = waits(ada)
    expect(tell).to_have_attribute("aria-pressed", "true")  # it may notify already, and can do no more
    tell.click()
    expect(ada.page.locator(BAR)).to_contain_text("This browser notifies you no more.")
    tell.click()
    expect(ada.page.locator(BAR)).to_contain_text("It cannot do so when none is open.")
    expect(tell).to_have_attribute("aria-pressed", "true")


def test_without_a_push_service_or_a_connection_the_press_says_so(portal, cast):
    ada = cast("ada")
    ada.allowed = ("ERR_", "net::")
    ada.context.add_init_script(
        "PushManager.prototype.subscribe = () => Promise.reject(new DOMException('no service', 'AbortError'))"
    )
    tell = waits(ada)
    tell.click()
    expect(ada.page.locator(BAR)).to_contain_text("its push service could not be reached")
    bob = cast("bob")
    bob.allowed = ("ERR_", "net::")
    with_service(bob)
    bob.page.goto("/log/")
    queue.join(portal.robot, bob.user, SYSTEM.now())
    tell = bob.page.get_by_role("button", name=TELL)
    expect(tell).to_be_visible()
    bob.page.route("**/me/push/", lambda route: route.abort())
    tell.click()
    expect(bob.page.locator(BAR)).to_contain_text("That could not be sent: there is no connection.")
    expect(tell).to_have_attribute("aria-pressed", "false")
    bob.page.unroute("**/me/push/")
    tell.click()
    expect(tell).to_have_attribute("aria-pressed", "true")
    assert PushSubscription.objects.get().user == bob.user


def test_the_service_worker_shows_what_is_pushed_and_keeps_no_page(portal, cast):
    ada = cast("ada")
    with_service(ada)
    waits(ada).click()
    expect(ada.page.get_by_role("button", name=TELL)).to_have_attribute("aria-pressed", "true")
    line = ada.context.new_cdp_session(ada.page)
    registered = []
    line.on("ServiceWorker.workerRegistrationUpdated", lambda said: registered.extend(said["registrations"]))
    line.send("ServiceWorker.enable")
    wait_for(lambda: ada.page.wait_for_timeout(20) or registered, 15, "the registration")
    assert registered[-1]["scopeURL"] == f"{portal.url}/"
    active = "navigator.serviceWorker.ready.then((r) => r.active.scriptURL)"
    assert ada.page.evaluate(active) == f"{portal.url}/push-worker.js"
    said = {
        "title": "It is your turn on Mercury", "body": "Take control before {time}.", "url": "/robots/mercury/", "lang": "en",
        "tag": "turn-mercury", "icon": "/static/portal/icon-turn.svg", "until_ms": 1_800_000_000_000,
    }  # fmt: skip
    push = {"origin": portal.url, "registrationId": registered[-1]["registrationId"], "data": json.dumps(said)}
    [worker] = ada.context.service_workers
    worker.evaluate(ASKED)
    line.send("ServiceWorker.deliverPushMessage", push)
    wait_for(lambda: ada.page.wait_for_timeout(50) or worker.evaluate("self.shown"), 15, "the notification")
    [[title, more]] = worker.evaluate("self.shown")
    assert title == "It is your turn on Mercury"
    assert re.fullmatch(r"Take control before \d+:\d\d:\d\d.*\.", more.pop("body"))
    assert more == {
        "tag": "turn-mercury", "lang": "en", "data": {"url": "/robots/mercury/"}, "requireInteraction": True,
        "icon": "/static/portal/icon-turn.svg",
    }  # fmt: skip
    assert ada.page.evaluate("caches.keys()") == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_persons_page_lists_the_browsers_with_remove(portal, cast, scheme):
    ada = cast("ada", viewport=PHONE, color_scheme=scheme)
    with_service(ada)
    ada.page.goto("/me/")
    expect(ada.page.locator("main")).to_contain_text("No browser tells you of your turn")
    waits(ada).click()
    expect(ada.page.get_by_role("button", name=TELL)).to_have_attribute("aria-pressed", "true")
    Ticket.objects.filter(user=ada.user).delete()
    ada.page.goto("/me/")
    expect(ada.page.locator("main")).to_contain_text("Chrome, Linux (this one), since")
    ada.axe(f"my browsers, {scheme}")
    assert ada.page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    ada.page.get_by_role("button", name=re.compile("Remove.*Chrome")).press("Enter")
    expect(ada.page.locator("main")).to_contain_text("That browser is told no more.")
    assert not PushSubscription.objects.exists()
