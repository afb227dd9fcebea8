"""Accounts in the reader's language: what the forms say, and the language of mails."""

import pytest
from django.core import mail
from django.utils import translation

from accounts import handles, passwords
from accounts.models import User

pytestmark = [pytest.mark.service, pytest.mark.django_db]

GERMAN = {"accept-language": "de"}
NEW = {"email": "new@example.org", "username": "newcomer", "password1": "correct horse 42"}


@pytest.mark.parametrize(
    ("handle", "said"),
    [
        ("x", "Verwenden Sie 2 bis 24 Zeichen."),
        ("two words", "keine Leerzeichen"),
        ("adа", "lateinisch und kyrillisch|kyrillisch und lateinisch"),
        ("--", "mindestens einen Buchstaben"),
        ("admin", "reserviert"),
    ],
)
def test_what_a_handle_lacks_is_said_in_the_readers_language(robot, handle, said):
    with translation.override("de"), pytest.raises(handles.ValidationError, match=said):
        handles.validate(handle)


def test_a_weak_password_is_refused_in_the_readers_language():
    with translation.override("de"), pytest.raises(passwords.ValidationError, match="leicht zu erraten"):
        passwords.OwnWordsValidator().validate("robot123")


def test_who_signs_up_in_german_gets_a_german_form_and_mails(robot, client):
    form = client.get("/accounts/signup/", headers=GERMAN).text
    assert "2 bis 24 Buchstaben einer Schrift" in form
    assert "Shown to others" not in form
    client.post("/accounts/signup/", NEW, headers=GERMAN)
    assert User.objects.get(username="newcomer").language == "de"
    (sent,) = mail.outbox
    assert "höchstwahrscheinlich Sie" in sent.body
    assert "Somebody" not in sent.body


@pytest.mark.parametrize(("language", "page", "said"), [("de", "en", "Guten Tag"), ("en", "de", "Hello"), ("", "de", "Hello")])  # fmt: skip
def test_a_mail_is_in_the_language_of_the_person_not_of_the_page(people, client, language, page, said):
    User.objects.filter(username="eve").update(language=language)
    address = User.objects.get(username="eve").email
    client.post("/accounts/password/reset/", {"email": address}, headers={"accept-language": page})
    (sent,) = mail.outbox
    assert said in sent.body
    assert sent.to == [address]


def test_a_mail_to_an_unknown_address_is_in_the_language_of_the_page(robot, client):
    client.post("/accounts/password/reset/", {"email": "nobody@example.org"}, headers=GERMAN)
    (sent,) = mail.outbox
    assert "Guten Tag" in sent.body


def test_who_signs_up_with_a_known_address_is_told_in_the_language_of_that_account(people, client):
    User.objects.filter(username="eve").update(language="de")
    client.post("/accounts/signup/", NEW | {"email": User.objects.get(username="eve").email})
    (sent,) = mail.outbox
    assert "Guten Tag" in sent.body
