"""The orientation and its test in the reader's language; in English where a package has no translation."""

import re
from html import unescape

import pytest

from accounts import services
from accounts.models import Attempt, Choice, Question
from accounts.services import load_bank
from robots.kit import description
from robots.kit.clock import SYSTEM
from robots.models import Robot

pytestmark = [pytest.mark.service, pytest.mark.django_db]

GERMAN = {"accept-language": "de"}
ORIENTATION, TEST = "/robots/mercury/orientation/", "/robots/mercury/clearance/"


@pytest.fixture
def table(robot, installed):
    """A robot whose package has a German orientation."""
    Robot.objects.filter(pk=robot.pk).update(driver="turntable")
    robot.refresh_from_db()
    Question.objects.filter(robot=robot).delete()
    load_bank(robot)
    return robot


def article(page):
    """Return the tag and the contents of the text of an orientation."""
    return re.search(r"<article([^>]*)>(.*?)</article>", unescape(page.text), re.DOTALL).groups()


def test_the_orientation_is_in_the_readers_language_with_the_same_anchors(table, client):
    english, german = article(client.get(ORIENTATION)), article(client.get(ORIENTATION, headers=GERMAN))
    assert "The turntable" in english[1]
    assert "Der Drehtisch" in german[1]
    assert re.findall(r'id="[^"]+"', german[1]) == re.findall(r'id="[^"]+"', english[1])
    assert "lang=" not in english[0] + german[0]


@pytest.mark.parametrize("text", ["", "# Kurz\n\nEin Absatz.", "# Der Tisch\n\na\n\nb\n\n[c](control:c)"])
def test_a_translation_that_does_not_fit_is_not_shown_and_english_says_that_it_is(table, client, monkeypatch, text):
    read = description.text_of
    monkeypatch.setattr(description, "text_of", lambda driver, name: text if ".de." in name else read(driver, name))
    tag, shown = article(client.get(ORIENTATION, headers=GERMAN))
    assert 'lang="en"' in tag
    assert "The turntable" in shown


def test_where_there_is_no_translation_the_english_text_says_that_it_is(robot, client, monkeypatch):
    read = description.text_of

    def only_english(driver, name):
        if ".de." in name:
            raise FileNotFoundError(name)
        return read(driver, name)

    monkeypatch.setattr(description, "text_of", only_english)
    tag, shown = article(client.get(ORIENTATION, headers=GERMAN))
    assert 'lang="en"' in tag
    assert "sand" in shown


def test_a_failed_test_leads_to_the_paragraph_of_the_translated_text(table, people, client):
    services.mark_read(people["eve"], table, SYSTEM.now())
    client.force_login(people["eve"])
    client.get(TEST, headers=GERMAN)
    attempt = Attempt.objects.get()
    wrong = Choice.objects.filter(question__in=[q for q, _ in attempt.drawn], correct=False)
    data = {"attempt": attempt.pk} | {f"q{one.question_id}": one.pk for one in wrong}
    page = unescape(client.post(TEST, data, headers=GERMAN, follow=True).text)
    link = re.search(rf'href="{ORIENTATION}#([^"]+)">([^<]+)</a>', page)
    assert link[2].startswith("Der Drehtisch, ")
    assert f'id="{link[1]}"' in client.get(ORIENTATION, headers=GERMAN).text


def test_questions_choices_and_topics_are_translated_and_those_of_staff_stay_as_written(robot, people, client, clock):
    load_bank(robot)
    own = Question.objects.create(robot=robot, text="Own question?", topic="Own topic", section="", paragraph=1)
    Choice.objects.bulk_create([Choice(question=own, text=f"own {n}", correct=n == 0) for n in range(4)])
    packaged = Question.objects.exclude(pk=own.pk).first()
    attempt = Attempt.objects.create(
        user=people["eve"], robot=robot, started_at=clock.now(),
        drawn=[[q.pk, [c.pk for c in q.choices.all()]] for q in (own, packaged)],
    )  # fmt: skip
    from django.utils import translation

    with translation.override("de"):
        first, second = services.questions(attempt)
        assert first.text == "Own question?"
        assert [text for _, text in first.choices] == [f"own {n}" for n in range(4)]
        assert second.text == translation.gettext(packaged.text)
        assert [text for _, text in second.choices] == [translation.gettext(c.text) for c in packaged.choices.all()]
