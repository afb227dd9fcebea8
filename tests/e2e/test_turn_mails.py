"""The button beside Web Push by which a person chooses an e-mail, too, when it is their turn."""

import pytest
from allauth.account.models import EmailAddress
from playwright.sync_api import expect

from accounts.models import TurnMail
from accounts.turn_mails import mail_choice
from queueing import services as queue
from robots.kit.clock import SYSTEM
from tests.e2e.bare import portal as portal
from tests.e2e.drawn import settle

BAR = "#turnbar"


def waits(visitor, confirmed, **options):
    """A person who waits on another page, while somebody else has the robot."""
    one = visitor(**options).cleared("ada", None)
    EmailAddress.objects.update_or_create(
        user=one.user, email=one.user.email, defaults={"verified": confirmed, "primary": True}
    )
    other = one.portal.person("other", "mercury")
    queue.join(one.portal.robot, other, SYSTEM.now())
    one.portal.serve()
    one.page.goto("/log/")
    queue.join(one.portal.robot, one.user, SYSTEM.now())
    expect(one.page.locator(BAR)).to_contain_text("before you")
    return one, one.page.get_by_role("button", name="Also by e-mail")


def test_one_press_has_the_turn_told_by_e_mail_and_another_ends_it(portal, visitor):
    ada, button = waits(visitor, confirmed=True, viewport={"width": 320, "height": 700})
    expect(button).to_have_attribute("aria-pressed", "false")
    assert not TurnMail.objects.exists(), "off at first"
    button.click()
    expect(ada.page.locator(BAR)).to_contain_text("An e-mail, too, tells you that it is your turn.")
    expect(button).to_have_attribute("aria-pressed", "true")
    assert mail_choice(ada.user)
    box = button.bounding_box()
    assert min(box["width"], box["height"]) >= 44
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= 320
    assert ada.page.evaluate("document.documentElement.scrollWidth") <= 320
    ada.axe("told by e-mail")
    ada.page.reload()
    expect(button).to_have_attribute("aria-pressed", "true")
    button.click()
    expect(button).to_have_attribute("aria-pressed", "false")
    expect(ada.page.locator(BAR)).to_contain_text("No e-mail tells you of it.")
    assert mail_choice(ada.user) is False


@pytest.mark.parametrize("width", [320, 390, 1440])
def test_a_choice_that_is_made_moves_no_button(portal, visitor, width):
    ada, _ = waits(visitor, confirmed=True, viewport={"width": width, "height": 844})
    ada.context.add_cookies([{"name": "django_language", "value": "de", "url": portal.url}])
    ada.page.add_init_script("window.Notification = class { static permission = 'default'; };")
    ada.page.reload()
    button, others = ada.page.get_by_role("button", name="Auch per E-Mail"), ada.page.locator(".turnbar-do .button")
    expect(others).to_have_count(3)
    settle(ada.page)
    before = [one.bounding_box() for one in others.all()]
    button.click()
    expect(button).to_have_attribute("aria-pressed", "true")
    expect(ada.page.locator(BAR)).to_contain_text("Auch eine E-Mail sagt Ihnen")
    settle(ada.page)
    assert [one.bounding_box() for one in others.all()] == before


def test_without_a_confirmed_address_there_is_no_button(portal, visitor):
    ada, button = waits(visitor, confirmed=False)
    expect(ada.page.get_by_role("button", name="Sound")).to_be_visible()
    expect(button).to_have_count(0)


def test_a_choice_that_is_not_stored_says_so_and_stays_as_it_was(portal, visitor):
    ada, button = waits(visitor, confirmed=True)
    ada.allowed = ("ERR_", "net::", "400")
    EmailAddress.objects.update(verified=False)
    button.click()
    expect(ada.page.locator(BAR)).to_contain_text("Confirm your e-mail address first.")
    expect(button).to_have_attribute("aria-pressed", "false")
    ada.page.route("**/me/choices/", lambda route: route.abort())
    button.click()
    expect(ada.page.locator(BAR)).to_contain_text("could not be sent")
    expect(button).to_have_attribute("aria-pressed", "false")


def test_the_choices_on_the_persons_page_are_switched_by_a_finger(portal, visitor):
    ada = visitor(viewport={"width": 390, "height": 844}, has_touch=True).cleared("ada", None)
    EmailAddress.objects.update_or_create(
        user=ada.user, email=ada.user.email, defaults={"verified": True, "primary": True}
    )
    ada.page.goto("/me/")
    for choice, label in (("mail", "Tell me by e-mail that it is my turn"), ("name", "Show my name")):
        form = ada.page.locator("form", has=ada.page.locator(f'[name="do"][value="{choice}"]'))
        box = form.get_by_label(label)
        before = box.is_checked()
        assert form.locator("label").bounding_box()["height"] >= 44
        form.locator("label").tap()
        with ada.page.expect_navigation():
            form.get_by_role("button", name="Save").tap()
        expect(box).to_be_checked(checked=not before)
    ada.axe("choices")
    ada.user.refresh_from_db()
    assert (ada.user.name_shown, mail_choice(ada.user)) == (False, True)
