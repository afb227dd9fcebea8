"""A turn's page: entry and survey in one form that loses nothing, and edits of a featured entry."""

import re

import pytest

from operatorlog import services
from operatorlog.models import Entry, SurveyAnswer, SurveyQuestion, SurveyResponse, Visibility
from robots.kit.clock import SYSTEM
from tests.services.test_log import ended, frame, turn  # noqa: F401

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def scale(db):
    return SurveyQuestion.objects.create(prompt="How easy?", kind="scale")


@pytest.fixture
def words(db):
    return SurveyQuestion.objects.create(prompt="What for?", kind="text", position=2)


@pytest.fixture
def page(ended, people, client):  # noqa: F811
    client.force_login(people["ada"])
    return lambda **data: client.post(ended.get_absolute_url(), data)


def test_one_form_takes_the_entry_and_the_answers(page, ended, people, client, scale, words):  # noqa: F811
    html = client.get(ended.get_absolute_url()).content.decode()
    assert html.count('<form method="post" class="form') == 1
    assert page(**{"text": "A watch.", f"s{scale.pk}": "4", f"s{words.pk}": "digs"}).status_code == 302
    assert Entry.objects.get().text == "A watch."
    assert sorted(SurveyAnswer.objects.values_list("value", flat=True)) == ["4", "digs"]


def test_either_may_be_left_empty_and_be_sent_later(page, scale):
    assert page(**{"text": "", f"s{scale.pk}": "4"}).status_code == 302
    assert (Entry.objects.count(), SurveyResponse.objects.count()) == (0, 1)
    assert page(text="Later.").status_code == 302
    assert Entry.objects.get().text == "Later."


def test_an_entry_alone_leaves_the_survey_open(page, ended, client, scale):  # noqa: F811
    assert page(**{"text": "First.", f"s{scale.pk}": ""}).status_code == 302
    assert not SurveyResponse.objects.exists()
    assert "How easy?" in client.get(ended.get_absolute_url()).content.decode()
    assert page(**{f"s{scale.pk}": "2"}).status_code == 302
    assert SurveyAnswer.objects.get().value == "2"
    assert Entry.objects.get().edited_at is None


def test_nothing_at_all_is_refused_in_words(page):
    answer = page(text="  ")
    assert answer.status_code == 422
    assert b"either is enough" in answer.content


@pytest.mark.parametrize("text", ["x" * 2001, "short"])
def test_an_error_saves_neither_and_gives_both_back(page, text, scale, words):
    choice = "3" if len(text) > 2000 else "17"
    answer = page(**{"text": text, f"s{scale.pk}": choice, f"s{words.pk}": "for <b>digs</b>"})
    assert answer.status_code == 422
    html = answer.content.decode()
    assert text in html
    assert "for &lt;b&gt;digs&lt;/b&gt;" in html
    if choice == "3":
        assert re.search(rf'name="s{scale.pk}" value="3"\s+checked', html)
    assert not Entry.objects.exists()
    assert not SurveyResponse.objects.exists()


def test_a_text_that_comes_too_late_is_shown_for_copying(page, ended, people):  # noqa: F811
    entry = services.write(ended, people["ada"], "first", None, SYSTEM.now())
    Entry.objects.update(written_at=entry.written_at.replace(year=2020))
    answer = page(text="a long correction")
    assert answer.status_code == 422
    assert b"a long correction" in answer.content


@pytest.mark.parametrize("name", ["frame", "s1", "s"])
@pytest.mark.parametrize("value", ["²", "9" * 5000, "-1", "\x00", ""])
def test_nonsense_in_a_field_is_no_500(page, name, value):
    assert page(**{"text": "x", name: value}).status_code in (302, 400, 422)


def test_pictures_keep_their_own_proportions(page, ended, client):  # noqa: F811
    made = frame(ended.robot, ended.grant)
    type(made).objects.filter(pk=made.pk).update(width=320, height=240)
    html = client.get(ended.get_absolute_url()).content.decode()
    assert 'width="320" height="240"' in html
    assert 'width="192"' not in html


@pytest.fixture
def featured(ended, people, clock):  # noqa: F811
    picture = frame(ended.robot, ended.grant)
    entry = services.write(ended, people["ada"], "worth reading", picture.pk, clock.now())
    services.moderate(entry, people["mod"], Visibility.FEATURED, "", clock.go(10))
    return entry


@pytest.mark.asvs("2.3.1")
@pytest.mark.parametrize("change", ["text", "picture"])
def test_what_was_featured_and_then_changed_is_featured_no_more(featured, people, clock, client, change):
    """Otherwise its author could put any words into the place that a moderator chose for others."""
    text, picture = ("buy my watches", featured.frame_id) if change == "text" else (featured.text, None)
    services.edit(featured, people["ada"], text, picture, clock.go(10))
    featured.refresh_from_db()
    assert featured.visibility == Visibility.PUBLISHED, "everybody may still read it"
    client.force_login(people["mod"])
    listed = client.get("/admin/operatorlog/entry/?edited=since").content.decode()
    assert featured.text in listed, "moderators are told that it was changed after they looked"
    services.moderate(featured, people["mod"], Visibility.FEATURED, "", clock.go(10))
    assert featured.text not in client.get("/admin/operatorlog/entry/?edited=since").content.decode()


def test_saving_without_a_change_keeps_it_featured(featured, people, clock):
    services.edit(featured, people["ada"], f" {featured.text} ", featured.frame_id, clock.go(10))
    featured.refresh_from_db()
    assert (featured.visibility, featured.edited_at) == (Visibility.FEATURED, None)


def test_an_edit_of_an_old_copy_brings_no_hidden_entry_back(featured, people, clock):
    services.moderate(Entry.objects.get(), people["mod"], Visibility.HIDDEN, "rude", clock.go(1))
    services.edit(featured, people["ada"], "other words", None, clock.go(1))  # `featured` still says featured
    assert Entry.objects.get().visibility == Visibility.HIDDEN


def test_hiding_without_a_reason_is_one_message(featured, people, client):
    client.force_login(people["mod"])
    address = f"/admin/operatorlog/entry/{featured.pk}/change/"
    form = {"visibility": "hidden", "revision": Entry.objects.get().revision, "words": " "}
    html = client.post(address, form, follow=True).content.decode()
    assert "Give the reason for hiding it" in html
    assert html.count("errornote") == 1
    answer = client.post(address, form | {"words": "rude"}, follow=True)
    assert "Hidden: the entry of ada" in answer.content.decode()
