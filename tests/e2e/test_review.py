"""The page on which moderators decide about entries, by keyboard alone, in English and German, and without scripts."""

import pytest
from django.contrib.auth.models import Permission
from playwright.sync_api import expect

from operatorlog import services as log
from operatorlog.models import Entry, HidingReason, Visibility
from robots.kit.clock import SYSTEM
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.test_axe import DARK, LIGHT
from tests.e2e.test_layout import OVER

REVIEW = "/admin/operatorlog/entry/review/"
REASONS = ("It is unkind to somebody.", "It is advertising.", "It gives away what others are to find out.")
FOCUS = "document.activeElement.id"
SMALL = """() => [...document.querySelectorAll('#desk button, #desk a, #desk input:not([type=hidden])')].filter((e) => {
  const r = e.getBoundingClientRect();
  return r.height && (r.height < 24 || r.width < 24);
}).map((e) => e.outerHTML)"""
WORDS = {
    "en": ("2 entries wait.", "Undo", "It is undone"),
    "de": ("2 Einträge warten.", "Rückgängig", "Rückgängig gemacht"),
}


@pytest.fixture
def staff(portal, visitor):
    """Open a browser of a moderator."""

    def make(**options):
        mia = portal.person("mia", is_staff=True)
        codes = ("view_entry", "change_entry", "change_hidingreason")
        mia.user_permissions.set(Permission.objects.filter(codename__in=codes))
        return session(visitor(**options), mia)

    return make


@pytest.fixture
def three(portal):
    """An entry that was hidden and is appealed against, one that lost its picture by a change, and a new one."""
    ada, root = portal.person("ada", "mercury"), portal.person("root", is_staff=True, is_superuser=True)
    made = [portal.entry(ada, "mercury", text) for text in ("A rude word.", "A watch in the sand.", "w" * 300)]
    for position, text in enumerate(REASONS, 1):  # of the migration, which another test may have removed
        HidingReason.objects.get_or_create(text=text, defaults={"position": position})
    log.moderate(made[0], root, Visibility.HIDDEN, HidingReason.objects.first().text, SYSTEM.now(), "Please.")
    log.appeal(made[0], ada, "It was a joke.", SYSTEM.now())
    log.moderate(made[1], root, Visibility.FEATURED, "", SYSTEM.now())
    log.edit(made[1], ada, "A clock in the sand.", None, SYSTEM.now())
    return made


def says(page, text, place=".says"):
    """Wait until the page shows the text and takes keys."""
    expect(page.locator(place)).to_contain_text(text)
    expect(page.locator("#desk.by-keys")).to_be_focused()


def visibility(entry):
    return Entry.objects.get(pk=entry.pk).visibility


@pytest.mark.parametrize("look", [LIGHT, DARK], ids=["wide", "narrow"])
@pytest.mark.parametrize("language", WORDS)
def test_a_moderator_works_through_what_waits_by_keyboard_alone(portal, staff, three, look, language):
    waiting, undo, undone = WORDS[language]
    one = staff(**look, locale=language)
    page, keys = one.page, one.page.keyboard
    page.goto(REVIEW)
    says(page, "A rude word.")
    one.axe("an appeal")
    assert page.evaluate(OVER) == []
    assert page.evaluate(SMALL) == []
    keys.press("r")
    keys.press("2")
    keys.press("Tab")
    assert page.evaluate(FOCUS) == "words"
    keys.press("Control+a")
    keys.type("a fuss, far away")  # with letters that are keys elsewhere
    keys.press("Enter")
    says(page, "A rude word.", ".done")
    first = Entry.objects.get(pk=three[0].pk)
    assert (first.visibility, first.hidden_words) == ("hidden", "a fuss, far away")
    assert first.hidden_reason == HidingReason.objects.all()[1].text
    expect(page.locator(".waiting")).to_have_text(waiting)
    expect(page.locator(".before")).to_have_text("A watch in the sand.")
    one.axe("a changed entry, after a decision")
    assert page.evaluate(OVER) == []
    expect(page.get_by_role("button", name=undo)).to_be_visible()
    keys.press("u")
    expect(page.locator(".messagelist")).to_contain_text(undone)
    says(page, "A rude word.")
    assert Entry.objects.get(pk=first.pk).why_hidden.endswith("Please.")
    keys.press("a")
    says(page, "A clock in the sand.")
    keys.press("s")
    says(page, "w" * 300)
    assert page.evaluate(OVER) == []
    keys.press("f")
    says(page, "www", ".done")
    assert [visibility(entry) for entry in three] == ["published", "published", "featured"]
    keys.press("s")
    says(page, "A clock in the sand.")
    keys.press("r")
    keys.press("ArrowDown")
    keys.press("Enter")
    expect(page.locator(".waiting")).not_to_contain_text("1")
    assert visibility(three[1]) == "hidden"
    one.axe("nothing waits")


def test_letters_do_nothing_outside_of_the_desk_nor_when_keys_are_off(portal, staff, three):
    page = staff(**LIGHT).page
    page.goto(REVIEW)
    page.locator(".breadcrumbs a").first.focus()
    page.keyboard.press("a")
    page.locator("#desk").focus()
    page.keyboard.press("Control+f")
    page.get_by_label("Keys of one letter").uncheck()
    page.keyboard.press("a")
    page.reload()
    expect(page.get_by_label("Keys of one letter")).not_to_be_checked()
    expect(page.locator("#desk kbd").first).to_be_hidden()
    for key in "afs1":
        page.keyboard.press(key)
    page.get_by_label("Keys of one letter").check()
    page.keyboard.press("s")
    says(page, "A clock in the sand.")
    assert log.to_review().count() == 3


def test_a_list_leads_there_and_all_of_it_works_without_scripts(portal, staff, three):
    page = staff(java_script_enabled=False).page
    page.goto("/admin/operatorlog/entry/")
    page.get_by_role("link", name="Review entries").last.click()
    assert not page.locator("#keys").is_visible()
    page.get_by_role("button", name="Hide", exact=True).click()
    assert page.locator(".done").inner_text().startswith("Hidden: the entry of ada, “A rude word.”")
    page.get_by_role("link", name="Later").click()
    page.get_by_label("It is advertising.").check()
    page.get_by_role("button", name="Hide", exact=True).click()
    page.get_by_role("button", name="Undo").click()
    assert page.locator(".says").inner_text() == "w" * 300
    page.get_by_role("button", name="Feature").click()
    page.get_by_role("link", name="Begin again with the oldest").click()
    page.get_by_role("button", name="Publish").click()
    assert [visibility(entry) for entry in three] == ["hidden", "published", "featured"]
    assert page.locator(".waiting").inner_text() == "Nothing waits."
