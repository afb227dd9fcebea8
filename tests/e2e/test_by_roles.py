"""A turn by what a screen reader is told: roles and names of what can be pressed, and what live regions say."""

import re

from playwright.sync_api import expect

from operatorlog.models import Entry
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.newcomer import end_turn
from tests.waiting import CEILING_S, wait_for

# what a screen reader says by itself, wherever the focus is
HEAR = """
window.heard = [];
document.addEventListener("DOMContentLoaded", () => new MutationObserver((changes) => {
  for (const { target } of changes) {
    const live = (target.nodeType === Node.ELEMENT_NODE ? target : target.parentElement)?.closest("[aria-live], [role=status], [role=alert]");
    if (live?.innerText) heard.push(live.innerText);
  }
}).observe(document.body, { childList: true, characterData: true, subtree: true, attributes: true, attributeFilter: ["hidden"] }));
"""


def test_a_turn_by_roles_names_and_what_live_regions_say(portal, visitor):
    one = session(visitor(), portal.person("ada", "mercury"))
    one.context.add_init_script(HEAR)
    page = one.page

    def press(role, name, key="Enter"):
        page.get_by_role(role, name=name, exact=True).press(key)

    def hears(words):
        said = lambda: page.wait_for_timeout(50) or any(words in one for one in page.evaluate("heard"))  # noqa: E731
        wait_for(said, CEILING_S, words)

    page.goto(portal.robot.get_absolute_url())
    expect(page.get_by_role("heading", name="Mercury", level=1)).to_be_visible()
    press("button", "Take control")
    hears("Asking for control…")
    portal.serve()
    hears("You drive")
    expect(page.get_by_role("heading", name="You drive")).to_be_visible()
    expect(page.get_by_role("timer").first).to_be_visible()
    expect(page.get_by_role("button", name="Down", exact=True)).to_be_disabled()
    press("button", "Up")
    wait_for(portal.perform, CEILING_S, "the command's row")
    hears("Up: done")
    press("button", "Stop")
    hears("Stop was sent.")
    press("checkbox", "I have looked at the newest picture and the way is clear.", "Space")
    press("button", "Release the stop")
    hears("The stop is released.")
    end_turn(page, lambda _: press("button", re.compile("^(End my turn|Press again to end it)$")))
    expect(page.get_by_role("heading", name="Your turn is over")).to_be_visible()
    press("link", "Write in the operator's log")
    page.get_by_role("textbox", name="Your entry in the operator's log").fill("A watch, at half past four.")
    press("button", "Send")
    expect(page.get_by_role("status").first).to_have_text("It is in the log. Thank you!")
    assert Entry.objects.get().author.username == "ada"
