"""Somebody who has never been here, and their way: from the landing page to a motion, the log and the survey."""

from playwright.sync_api import expect

from accounts.models import Choice
from operatorlog.models import Entry, SurveyResponse
from queueing.models import Turn
from tests.e2e.conftest import confirmation, mailed
from tests.keystrokes import FIELDS, MAIL_PRESSES, PRESS_S, reading_s, typing_s
from tests.waiting import CEILING_S, wait_for

COUNT = "addEventListener('pointerdown', (event) => { if (event.isTrusted) counted() }, true);"
FOCUS = "() => document.activeElement.tagName"
HERE, GROUP = "e => e === document.activeElement", "e => e.name === document.activeElement.name"
MOST_TABS = 300  # more than any page has to stop at


class Newcomer:
    """Somebody with a browser, who presses what is shown; their presses are counted, and the seconds that they need.

    The seconds are those of the keystroke-level model, with what they read; not what this machine needs. Of all presses,
    `beside` are those into fields and in a program for mails.
    """

    def __init__(self, visitor, touches=False):
        self.presses, self.beside, self.seconds = 0, 0, 0.0
        self._touches = touches
        self.page = visitor.page
        visitor.context.expose_function("counted", self._counted)
        visitor.context.add_init_script(COUNT)

    def _counted(self):
        self.presses += 1
        self.seconds += PRESS_S

    def read(self, what):
        """Read a part of the page."""
        self.seconds += reading_s(self.find(what).inner_text())

    def find(self, what, within="body"):
        """Return a link, a button or a choice that the page shows."""
        found = self.page.locator(within).locator(what).locator("visible=true").first
        expect(found).to_be_visible()
        return found

    def press(self, what, within="body"):
        """Press it."""
        found = self.find(what, within)
        found.tap() if self._touches else found.click()

    def fill(self, fields):
        """Write into fields by their names, each after a press into it."""
        for name, text in fields.items():
            self.press(f"[name={name}]")
            self.beside += 1
            self.page.fill(f"[name={name}]", text)
            self.seconds += typing_s(text)

    def open_mail(self, address):
        """Open the newest mail to an address, read it as far as its link, and press that."""
        link = confirmation(address)
        self.presses += MAIL_PRESSES
        self.beside += MAIL_PRESSES
        self.seconds += MAIL_PRESSES * PRESS_S + reading_s(mailed(address).partition(link)[0])
        self.page.goto(link)


class ByKeyboard(Newcomer):
    """Somebody who has nothing but a keyboard: Tab until it is reached, then Enter; arrows among choices."""

    def press(self, what, within="body"):
        """Reach it and press it."""
        found = self.find(what, within)
        kind = found.get_attribute("type")
        self._reach(found, GROUP if kind == "radio" else HERE)
        if kind == "radio":
            self._choose(found)
        else:
            self.page.keyboard.press("Space" if kind == "checkbox" else "Enter")

    def fill(self, fields):
        """Reach each field and type."""
        for name, text in fields.items():
            self._reach(self.find(f"[name={name}]"), HERE)
            self.page.keyboard.type(text)

    def _reach(self, found, there):
        for _ in range(MOST_TABS):
            if found.evaluate(there):
                return
            self.page.keyboard.press("Tab")
        raise AssertionError(f"{found} is not reached by Tab from {self.page.url}")

    def _choose(self, found):
        """Go round the choices; what one stands on from the beginning is chosen by Space alone."""
        while not found.evaluate(HERE):
            self.page.keyboard.press("ArrowDown")
        self.page.keyboard.press("Space")
        expect(found).to_be_checked()


def sign_up(new):
    """Come from the landing page to an account, on the way to driving a robot."""
    page = new.page
    page.goto("/")
    expect(page.locator("main")).to_contain_text("Simulated")
    new.read(".pitch")
    new.press("main a >> text=Drive Mercury")
    page.wait_for_url("**/accounts/signup/**")
    new.fill(FIELDS)
    new.press("main button[type=submit]")
    page.wait_for_url("**/confirm-email/")
    new.read("main p")
    new.open_mail(FIELDS["email"])
    page.wait_for_url("**/orientation/")


def get_cleared(new):
    """Read the orientation and pass the test."""
    page = new.page
    expect(page.locator("main")).to_contain_text("I'm here")
    expect(page.locator("main")).not_to_contain_text("at rest")
    new.read("article")
    new.press("main form button")
    page.wait_for_selector("main input[type=radio]")
    new.read("main form")
    for choice in Choice.objects.filter(correct=True).values_list("pk", flat=True):
        if page.locator(answer := f"input[type=radio][value='{choice}']").count():
            new.press(answer)
    new.press("main form button[name=then]")
    page.wait_for_url("**/robots/mercury/")
    expect(page.locator(".robot-head")).to_contain_text("Simulated")


def take_turn(new, motion, serve=lambda: None):
    """Wait for control until a motion is possible; `serve` advances the queue where nothing else does."""
    page = new.page
    serve()
    expect(page.locator(f"[data-command={motion}]")).to_have_attribute("aria-disabled", "false")


def command(new, name):
    """Press a command's button until the page has listed it: on a busy machine a state may come late just then."""

    def listed():
        return new.page.locator("#ladder li").count()

    wait_for(lambda: listed() or new.press(f"[data-command={name}]") or listed(), CEILING_S, f"the command {name}")


ASKS = """() => { window.asks = 0; const said = document.getElementById("say");
  new MutationObserver(() => { if (said.textContent.startsWith("Press again")) window.asks += 1; }).observe(said, { childList: true }); }"""
LONG_AGO = "(at) => performance.now() - at > 500"  # a double click is one press


def end_turn(page, press=None):
    """Press twice, as the page asks; a question that a busy machine lets go by is asked, and answered, once more."""
    press = press or page.click
    page.evaluate(ASKS)
    ended = Turn.objects.exclude(ended_at=None)
    before, asks = ended.count(), 0
    while True:
        press("[data-do=leave]")
        wait_for(lambda: ended.count() > before or page.evaluate("asks") > asks, CEILING_S, "an answer to the press")  # noqa: B023 - called at once
        if ended.count() > before:
            return
        asks = page.evaluate("asks")
        expect(page.locator("[data-do=leave]")).to_have_text("Press again to end it")
        page.wait_for_function(LONG_AGO, arg=page.evaluate("performance.now()"))


def write(new):
    """Write into the log what was found, and answer the survey."""
    page = new.page
    new.press("text=Write in the operator's log")
    page.wait_for_url("**/turns/**")
    new.fill({"text": "The sand took the mark of the nozzle.\nIt stays there."})
    new.press("input[type=radio][name^=s]")
    new.press("main form.form button")
    expect(page.locator("main")).to_contain_text("It is in the log")
    assert Entry.objects.count() == SurveyResponse.objects.count() == 1
