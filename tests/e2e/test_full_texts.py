"""A browser counts its own way how much fits into a field; whatever it lets somebody write is taken, once."""

import pytest
from playwright.sync_api import expect

from operatorlog.models import Entry, SurveyAnswer, SurveyResponse
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session

pytestmark = pytest.mark.timed


LINE = "A watch \U0001f916, at\nhalf past four.\n"


def test_a_field_filled_to_its_end_with_lines_and_emoji_is_stored_as_written_by_a_double_press(portal, visitor):
    ada = portal.person("ada", "mercury")
    turn = portal.end(portal.drive(ada, "mercury"))
    one = session(visitor(), ada)
    page = one.page
    page.goto(turn.get_absolute_url())
    written = []
    for field in (page.locator("#text"), page.locator("textarea[name^=s]")):
        most = int(field.get_attribute("maxlength"))
        field.focus()
        page.keyboard.insert_text(LINE * (most // 20))  # more than fits
        assert field.evaluate("(f) => f.value.length") in (most, most - 1)  # no half of an emoji
        written.append(field.input_value().strip())
    page.locator("main form.form button").dblclick()
    expect(page.locator(".messages")).to_contain_text("your answers are kept")
    assert Entry.objects.get().text == written[0]
    assert SurveyAnswer.objects.get().value == written[1]
    assert SurveyResponse.objects.count() == 1
    page.go_back()
    page.reload()
    expect(page.locator(".entry").first).to_be_visible()
    assert Entry.objects.count() == 1
