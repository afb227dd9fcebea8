"""The reader's language and time zone: chosen, remembered, and never broken by what a browser sends."""

import re
from io import BytesIO
from pathlib import Path

import allauth
import pytest
from babel.messages.pofile import read_po
from django.utils import timezone, translation

from accounts.models import User

pytestmark = pytest.mark.django_db
GERMAN = "de/LC_MESSAGES/django.po"


def test_the_browser_chooses_until_the_person_does(client):
    german = {"accept-language": "fr, de-AT;q=0.8, en;q=0.5"}
    page = client.get("/story/", headers=german)
    assert '<html lang="de">' in page.text
    assert page["Content-Language"] == "de"
    assert {"Accept-Language", "Cookie"} <= set(page["Vary"].split(", "))
    assert client.post("/language/", {"language": "en", "next": "/story/"}).url == "/story/"
    assert '<html lang="en">' in client.get("/story/", headers=german).text


def test_each_language_is_offered_by_its_own_name(client):
    page = client.get("/story/", headers={"accept-language": "de"}).text
    assert '<button class="linklike" name="language" value="en" lang="en">English</button>' in page
    assert '<button class="linklike" name="language" value="de" lang="de" aria-current="true">Deutsch</button>' in page


def test_english_pages_load_no_texts_and_others_load_theirs(client):
    assert "/texts/" not in client.get("/story/").text
    page = client.get("/story/", headers={"accept-language": "de"}).text
    address = page.split('<script src="')[1].split('"')[0]
    script = client.get(address)
    assert script["Content-Type"].startswith("text/javascript")
    assert "immutable" in script["Cache-Control"]
    assert script.text.rstrip().endswith("globalThis.texts = globalThis.django;")
    assert client.get("/texts/de/other.js")["Cache-Control"] == "no-store"
    assert client.get("/texts/xx/other.js").status_code == 404


@pytest.mark.parametrize("language", ["xx", "", "../de", "de\0", "d" * 5000])
def test_an_unknown_language_changes_nothing(client, language):
    answer = client.post("/language/", {"language": language, "next": "/story/"})
    assert answer.status_code in (302, 400)
    client.cookies["django_language"] = "../../etc"
    assert '<html lang="en">' in client.get("/story/").text


def test_the_switch_leads_to_no_other_site(client):
    assert client.post("/language/", {"language": "de", "next": "https://evil.example/"}).url == "/"


def test_the_choice_of_a_person_is_the_language_of_mails(client, django_user_model):
    user = django_user_model.objects.create_user("ada", "ada@example.org", "x")
    client.force_login(user)
    client.post("/language/", {"language": "de"})
    assert User.objects.get(pk=user.pk).language == "de"
    client.post("/language/", {"language": "xx"})
    assert User.objects.get(pk=user.pk).language == "de"


@pytest.mark.parametrize(
    ("zone", "shown"),
    [("Europe/Berlin", "Europe/Berlin"), ("Pacific/Kiritimati", "Pacific/Kiritimati"), ("", "UTC"), ("../etc/passwd", "UTC"),
     ("x" * 5000, "UTC"), ("Europe/Berlin\n", "UTC")],
)  # fmt: skip
def test_times_are_in_the_zone_of_the_browser_if_it_exists(client, zone, shown):
    seen = []
    client.cookies["zone"] = zone
    from portal.web.translation.middleware import ReaderZone

    request = client.get("/story/").wsgi_request
    ReaderZone(lambda r: seen.append(timezone.get_current_timezone_name()) or r)(request)
    assert seen == [shown]
    assert timezone.get_current_timezone_name() == "UTC"


def test_pages_of_allauth_address_people_as_ours_do(client, django_user_model):
    """Its German says du."""
    german, found = {"accept-language": "de"}, ""
    for address in ("login", "signup", "password/reset", "password/reset/done", "confirm-email"):
        found += client.get(f"/accounts/{address}/", headers=german).text
    client.force_login(django_user_model.objects.create_user("ada", "ada@example.org", "x"))
    for address in ("email", "logout", "password/change"):
        found += client.get(f"/accounts/{address}/", headers=german).text
    assert "Sie" in found
    assert re.findall(r"\b(?:du|dein\w*|dir|dich)\b.{40}", found, re.IGNORECASE) == []


def test_no_page_and_mail_of_accounts_says_du():
    """Also those that need a situation of their own, as the mail to somebody who has an account already."""
    catalogue = read_po(BytesIO(Path(allauth.__file__).with_name("locale").joinpath(GERMAN).read_bytes()))
    used = re.compile(r"templates/account/(?!.*(phone|verified_email_required))|\baccount/(adapter|forms|views)\.py")
    texts = [one.id for one in catalogue if isinstance(one.id, str) and any(used.search(at) for at, _ in one.locations)]
    assert len(texts) > 50
    with translation.override("de"):
        said = [translation.gettext(text) for text in texts]
    assert [
        text for text in said if re.search(r"\b(?:du|dein\w*|dir|dich|bestätige|wähle|gib)\b", text, re.IGNORECASE)
    ] == []
