"""The whole portal as processes of its own, and a real browser."""

import os
import re
import shutil
import time  # noqa: TID251 - the limit of a wait
from email import message_from_bytes
from pathlib import Path

import pytest
from django.conf import settings
from playwright.sync_api import Page, expect, sync_playwright

from accounts.services import load_bank
from queueing.models import Queue, Ticket, Turn
from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Command, Grant, Lease, Robot
from robots.states import Cycle
from tests import waiting
from tests.conftest import wait_for
from tests.e2e.bare import BarePortal
from tests.e2e.roaming import RoamingPortal
from tests.faults.controls import LOST

AXE = Path(__file__).resolve().parents[2] / "frontend/node_modules/axe-core/axe.min.js"
# where Redis answers late a code is refused; the page goes on without a stream of its own and asks again
ASKS_AGAIN = re.compile(r"status of 503 .*/stream-code/")
AXE_RUN = "async () => (await axe.run(document, {resultTypes: ['violations'], rules: {'target-size': {enabled: true}}})).violations.map(v => v.id + ': ' + v.nodes.map(n => n.target.join(' ') + ' ' + (n.any[0]?.message || '')).slice(0, 4).join('; '))"
# an animation in a page that is not drawn never finishes
RESTED = "() => Promise.race([Promise.allSettled(document.getAnimations().map((a) => a.finished)), new Promise((r) => setTimeout(r, 5000))])"
LETS_GO_S = 60


@pytest.fixture(autouse=True)
def patience():
    """How long a page may take is judged of timed tests alone."""
    expect.set_options(timeout=1000 * (waiting.shortest_s or 15))


class Portal:
    """Web process, housekeeping, one robot with its worker and simulator; all run on for the next test."""

    def __init__(self, robot, house):
        self.robot, self._house = robot, house
        self.sim = house.simulator_of(robot)
        house.owner_of(robot)
        house.housekeeping()
        self.url = house.web_process().url
        wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 60, "the robot is ready")

    @property
    def web(self):
        return self._house.web

    @web.setter
    def web(self, process):
        self._house.web = process

    @property
    def worker(self):
        return self._house.owner

    @worker.setter
    def worker(self, process):
        self._house.owner = process

    def told(self):
        """Return what rows and processes say, for whoever reads a failure."""
        rows = [list(model.objects.values()) for model in (Robot, Lease, Queue, Ticket, Turn, Grant)]
        said = [child.said()[-2000:] for child in (self._house.housekeeper, self.worker) if child is not None]
        return f"{SYSTEM.now()}", *rows, *said


@pytest.fixture
def portal(transactional_db, redis_server, robot, house):
    if house.robot(robot.slug) is None:
        bus.connection().flushall()
    shutil.rmtree(settings.VAR / "mail", ignore_errors=True)
    load_bank(robot)
    made = Portal(robot, house)
    yield made
    print(*made.told(), sep="\n")  # shown with a failure only
    if redis_server.process is None:
        redis_server.start()
    house.settle()


@pytest.fixture
def bare(transactional_db, redis_server, house):
    """The web process over rows alone; tests that need it take it as their `portal`."""
    bus.connection().flushall()
    shutil.rmtree(settings.VAR / "mail", ignore_errors=True)
    made = BarePortal(house.web_process())
    yield made
    made.stop()


@pytest.fixture
def roaming(transactional_db, redis_server, house):
    """The web process over rows and an owner's packets of the iRat; tests that need it take it as their `portal`."""
    bus.connection().flushall()
    made = RoamingPortal(house.web_process())
    yield made
    made.stop()


@pytest.fixture(scope="package")  # its event loop must be gone before other packages run theirs
def chromium():
    path = os.environ.get("FARHAND_CHROMIUM")
    if not path:
        pytest.fail("no Chromium was found; run `make setup-test`")
    libs = os.environ.get("FARHAND_CHROMIUM_LIBS")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=path,
            env={**os.environ, "LD_LIBRARY_PATH": libs} if libs else None,
            args=[
                "--no-sandbox",
                "--disable-gpu-compositing",  # without a graphics card that took a core of its own
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
                "--disable-quic",
                "--no-first-run",
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
            ],
        )
        yield browser
        browser.close()


class Visitor:
    """One person with a browser of their own; any console error fails the test."""

    def __init__(self, browser, portal, **options):
        self.portal = portal
        self._scripts = options.get("java_script_enabled", True)
        self.context = browser.new_context(
            base_url=portal.url, **{"locale": "en-US", "viewport": {"width": 1280, "height": 860}, **options}
        )
        if waiting.shortest_s:
            self.context.set_default_timeout(1000 * waiting.shortest_s)
        self.errors: list[str] = []
        self.allowed: tuple[str, ...] = ()
        self.page: Page = self.new_page()

    def new_page(self):
        page = self.context.new_page()
        page.on("console", self._heard)
        page.on("pageerror", lambda e: self.errors.append(str(e)))
        return page

    def _heard(self, message):
        of_the_test = (
            "inline style" in message.text and not message.location["url"]
        )  # what a test injects has no address
        if message.type == "error" and not of_the_test:
            self.errors.append(f"{message.text} {message.location}")

    def sign_up(self, name):
        page = self.page
        page.goto("/accounts/signup/")
        page.fill("[name=email]", f"{name}@example.org")
        page.fill("[name=username]", name)
        page.fill("[name=password1]", "correct horse 42")
        page.click("main button[type=submit]")
        page.wait_for_url("**/confirm-email/")
        page.goto(confirmation(f"{name}@example.org"))  # with scripts it confirms itself: this browser signed up
        if not self._scripts:
            page.click("main button")
        page.wait_for_url(lambda url: "confirm-email" not in url)
        return self

    def get_cleared(self):
        from accounts.models import Choice

        page = self.page
        slug = self.portal.robot.slug
        page.goto(f"/robots/{slug}/orientation/")
        page.click("main form button")
        page.wait_for_selector("main input[type=radio]")  # the next page: a click does not wait for it
        right = set(Choice.objects.filter(correct=True).values_list("pk", flat=True))
        for box in page.query_selector_all("input[type=radio]"):
            if int(box.get_attribute("value")) in right:
                box.check()
        page.locator("main form button").last.click()
        page.wait_for_url(f"**/robots/{slug}/")
        return self

    def cleared(self, name, address="/robots/{}/"):
        """Be somebody who signed up and passed long ago, by rows and a session; stand on the robot's page, or nowhere."""
        from accounts.models import Clearance, User

        robot = self.portal.robot
        self.user = User.objects.create_user(name, f"{name}@example.org", "correct horse 42")
        Clearance.objects.create(user=self.user, robot=robot, granted_at=SYSTEM.now())
        session(self, self.user)
        if address is not None:
            self.page.goto(address.format(robot.slug))
        return self

    def follow_menu(self, words):
        """Go where the menu of every page leads, on a phone after it was opened."""
        link = self.page.locator(".menu a", has_text=words)
        if not link.is_visible():
            self.page.click(".menu-open")
        link.click()

    def take_turn(self):
        """Take control of a robot that is free, or wait for the offer, until the page has the turn; return the visitor."""
        pressed = self.page.locator("[data-do=take], [data-do=join]").first
        waits = pressed.get_attribute("data-do") == "join"
        pressed.click()
        if waits:
            self.page.locator("[data-do=accept]").press("Enter", timeout=30_000)
        self.page.wait_for_selector(".operating", timeout=30_000)
        return self

    def axe(self, where=""):
        page = self.page
        if not page.evaluate("() => 'axe' in window"):  # given as it is: an argument would be read thrice
            self.context.new_cdp_session(page).send("Runtime.evaluate", {"expression": AXE.read_text()})
        for _ in range(3):  # a colour half-way between two states is nobody's, and on a busy machine states come late
            page.evaluate(RESTED)
            found = page.evaluate(AXE_RUN)
            if not found:
                break
        assert found == [], f"{where} {page.url}: {found}"

    def ladder(self, state="completed", timeout=40, also=()):
        """Wait until the newest command has ended, so or so; return its text."""
        ended = ["completed", "rejected", "failed", "cancelled", "expired", "unknown"]
        item = self.page.locator("#ladder li").first
        timeout = max(timeout, waiting.shortest_s)
        end = time.monotonic() + timeout
        while (found := item.get_attribute("data-state")) not in ended:
            if time.monotonic() > end:
                raise AssertionError(f"its end: not within {timeout} s: {item.inner_text()}, {self._told()}")
            self.page.wait_for_timeout(30)
        assert found in (state, *also), item.inner_text()
        return item.inner_text()

    def lets_go(self, held):
        """Call what holds a control and lets it go, and see the motion end by that.

        A page that drew for half a second has sent no keep-alives meanwhile, and is told so: it holds again.
        """
        end = time.monotonic() + LETS_GO_S
        while True:
            self.mark_newest()
            held()
            expect(self.newer()).to_be_attached()
            if LOST not in self.ladder(also=("cancelled",)):
                break
            if time.monotonic() > end:
                raise AssertionError(f"a motion that is let go before it is lost: not within {LETS_GO_S} s")
        self.ladder()
        newest = Command.objects.order_by("-pk")[0]
        assert newest.result.get("ended") == "released", newest.result

    def hold_until(self, control, press, release, far, what, within_s=60):
        """Hold a control until the robot has come so far. What the page refused, or has lost since, is pressed again."""

        def moves():
            if not self.page.locator(".held").count():
                release()
                expect(control).to_have_attribute("aria-disabled", "false")
                press()
            return far()

        wait_for(moves, within_s, what)

    def _told(self):
        """Return what the rows, the page and the owner say, for a command that does not end."""
        rows = list(Command.objects.order_by("-pk").values("pk", "kind", "state", "reason", "sent_at", "ended_at")[:3])
        owner = getattr(self.portal, "worker", None)
        return rows, self.page.inner_text("#state"), owner and (owner.alive(), owner.said()[-1500:])

    def press(self, name, state="completed"):
        """Give a command by its button, and wait until it has ended, so; return its text."""
        self.give(name)
        return self.ladder(state)

    def give(self, name):
        """Press a command's button until the command stands in the list.

        On a busy machine a state may come late, just then; the page says so, and one presses again.
        """
        button = self.page.locator(f"[data-command={name}]")
        for _ in range(3):
            expect(button).to_have_attribute("aria-disabled", "false")
            self.mark_newest()
            button.click()
            self.page.wait_for_timeout(60)
            if self.newer().count():
                return  # what the page says may be of the press before
        raise AssertionError(f"the command {name}: not within three presses: {self.page.inner_text('#notice')}")

    def mark_newest(self):
        """Mark the newest command, to tell one that comes after it."""
        self.page.evaluate("() => document.querySelector('#ladder li')?.setAttribute('data-seen', '')")

    def newer(self):
        """Return the command that has come since, if one has."""
        return self.page.locator("#ladder li:first-child:not([data-seen])")

    def close(self):
        self.context.close()
        bad = [e for e in self.errors if not any(a in e for a in self.allowed) and not ASKS_AGAIN.search(e)]
        assert bad == [], bad


CONFIRMS = re.compile(r"http://\S+/confirm-email/\S+")


def mailed(address):
    """Return the text of the newest mail to that address which has a link that confirms it."""

    def text():
        for path in sorted((settings.VAR / "mail").glob("*"), reverse=True):
            for part in path.read_bytes().split(b"-" * 79):
                message = message_from_bytes(part.strip())
                if address in (message["To"] or ""):
                    said = message.get_payload(decode=True).decode()
                    if CONFIRMS.search(said):
                        return said
        return None

    return wait_for(text, 10, "the mail")


def confirmation(address):
    """Return the link in that mail."""
    return CONFIRMS.search(mailed(address))[0]


@pytest.fixture
def visitor(chromium, portal):
    made = []

    def make(**options):
        made.append(Visitor(chromium, portal, **options))
        return made[-1]

    yield make
    for one in made:
        one.close()


def session(visitor, user):
    """Give the visitor's browser a session of that person, as a sign-in would; return the visitor."""
    from django.conf import settings
    from django.contrib.auth import BACKEND_SESSION_KEY, HASH_SESSION_KEY, SESSION_KEY
    from django.contrib.sessions.backends.db import SessionStore

    store = SessionStore()
    store[SESSION_KEY] = str(user.pk)
    store[BACKEND_SESSION_KEY] = "accounts.backends.ConstantTimeBackend"
    store[HASH_SESSION_KEY] = user.get_session_auth_hash()
    store.save()
    visitor.context.add_cookies(
        [{"name": settings.SESSION_COOKIE_NAME, "value": store.session_key, "url": visitor.portal.url}]
    )
    return visitor
