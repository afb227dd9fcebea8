"""The admin in the reader's language: the portal's own texts on its pages are marked, whatever model they show."""

import json
import re
from datetime import datetime

import pytest
from django.apps import apps
from django.contrib import admin
from django.contrib.admin.models import LogEntry
from django.urls import reverse
from django.utils import translation

from portal.live.snapshot import snapshot
from robots.kit.clock import SYSTEM
from robots.kit.installed import drivers
from robots.models import Incident, Robot
from robots.sentences import english, translate
from robots.services.status import status_of
from robots.states import Cycle
from tests.services.admin_forms import as_sent, controls_of
from tests.services.browsers import signed_in
from tests.services.marked import PSEUDO, TURNED, WORD, Texts

pytestmark = [pytest.mark.service, pytest.mark.django_db]
NAMES = {"Farhand", "UTC", "English", "Deutsch", "Pseudo", "ID", "cm", "mm", "rad", "None", "mercury"}
OF_DJANGO = re.compile(  # texts of Django that it does not have in Arabic, of which the pseudo-language is a variant
    "Disabled|Enabled|Password-based|Raw passwords|Reset password|Control|Search|Whether the user will be able|hash|salt|md5|[*]{9}"
)


def pages():
    """Yield the addresses of the admin: of each model its list, the page of a new row and those of some rows."""
    yield from ("/admin/", "/admin/live/")
    for model in admin.site._registry:
        name = f"admin:{model._meta.app_label}_{model._meta.model_name}"
        yield from (reverse(f"{name}_changelist"), reverse(f"{name}_add"))
        yield from (reverse(f"{name}_change", args=[row.pk]) for row in model._default_manager.all()[:3])


def strings(value):
    """Yield the texts in a value of a row."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, list | dict):
        yield json.dumps(value)
        for one in value.values() if isinstance(value, dict) else value:
            yield from strings(one)


def data():
    """Return what rows hold, the longest first: no page translates it."""
    rows = (row for model in apps.get_models() for row in model._default_manager.all())
    values = (one.value_from_object(row) for row in rows for one in row._meta.concrete_fields)
    found = {text for value in values for text in strings(value)}
    return sorted({text for text in found if WORD.search(text)}, key=len, reverse=True)


def test_every_text_of_the_admin_is_in_the_readers_language(used):
    rows = [*data(), *drivers()]
    client, left, shown = signed_in(used["root"], headers={"accept-language": PSEUDO}), {}, 0
    known = re.compile(rf"(?<!\w)({'|'.join(map(re.escape, rows))})(?!\w)")
    for page in pages():
        answer = client.get(page)
        assert answer.status_code == 200 or page.endswith("/add/"), page
        texts = Texts(answer.text).found if answer.status_code == 200 else []
        shown += len(texts)
        for text in texts:
            rest = TURNED.sub("", text).strip()
            if not WORD.search(rest) or rest in rows or OF_DJANGO.search(text):
                continue
            if set(WORD.findall(known.sub("", rest))) - NAMES:
                left.setdefault(text.strip(), page)
    assert shown > 1000
    assert left == {}


def test_numbers_that_browsers_read_are_not_written_in_the_readers_language(used):
    second = Robot.objects.order_by("pk")[1]
    page = (
        signed_in(used["root"], headers={"accept-language": "de"}).get(f"/admin/robots/robot/{second.pk}/change/").text
    )
    assert "Verbindung testen" in page
    assert not re.search(r'\b(value|min|max|step|width|height)="\d+,\d', page)


@pytest.mark.parametrize("model", ["robots/robot", "accounts/clearance", "operatorlog/round", "accounts/question"])
def test_a_form_in_another_language_is_saved_as_it_came(used, model):
    client = signed_in(used["root"], headers={"accept-language": "de"})
    client.cookies["zone"] = "Asia/Kolkata"
    rows = apps.get_model(*model.split("/"))._default_manager
    row = rows.first()
    page = f"/admin/{model}/{row.pk}/change/"
    form = as_sent(controls_of(client.get(page)), _continue="1")
    assert client.post(page, form).status_code == 302
    after = rows.get(pk=row.pk)
    for name in (one.name for one in row._meta.concrete_fields):
        now, before = getattr(after, name), getattr(row, name)
        assert now == (before.replace(microsecond=0) if isinstance(before, datetime) and now != before else before)


def test_what_many_people_are_sent_is_english_whoever_asks(robot, people, owned):
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.HANDOVER)
    robot.refresh_from_db()
    with translation.override("de"):
        assert str(Cycle.HANDOVER.label) != "Being put back in order"
        assert english(Cycle.HANDOVER.label) == "Being put back in order"
        assert status_of(robot, SYSTEM.now())[1] == "Being put back in order"
        sent = json.dumps(snapshot(robot.slug, people["ada"], SYSTEM.now(), True))
    assert "Being put back in order" in sent


def test_the_history_of_a_row_is_english_and_the_message_is_not(robot, people, django_user_model):
    root = django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")
    incident = Incident.objects.create(robot=robot, at=SYSTEM.now(), code="x", text="It was pushed.")
    chosen = {"action": "close", "_selected_action": str(incident.pk)}
    page = signed_in(root, headers={"accept-language": "de"}).post("/admin/robots/incident/", chosen, follow=True)
    assert "Erledigt: 1 Störung." in page.text
    assert LogEntry.objects.get().get_change_message() == "Dealt with"
    history = f"/admin/robots/incident/{incident.pk}/history/"
    assert "<td>Erledigt</td>" in signed_in(root, headers={"accept-language": "de"}).get(history).text
    assert "<td>Dealt with</td>" in signed_in(root).get(history).text


def test_a_sentence_of_the_portal_is_translated_in_lists_and_on_pages(robot, django_user_model):
    root = django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")
    said = "The arm's control application was started again by its watchdog."
    incident = Incident.objects.create(robot=robot, at=SYSTEM.now(), code="x", text="It was pushed.", remedy=said)
    client = signed_in(root, headers={"accept-language": "de"})
    for page in ("/admin/robots/incident/", f"/admin/robots/incident/{incident.pk}/change/"):
        text = client.get(page).text
        assert said not in text
        assert "It was pushed." in text  # nobody knows its translation


def test_icons_and_permissions_are_named_in_the_readers_language(people, django_user_model):
    root = django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")
    german = signed_in(root, headers={"accept-language": "de"})
    page = german.get("/admin/accounts/user/").text
    assert 'alt="Ja"' in page and 'alt="Nein"' in page and 'alt="True"' not in page
    page = german.get(f"/admin/accounts/user/{root.pk}/change/").text
    assert "| Roboter | Ändern: Roboter<" in page and "Can " not in page
    assert 'alt="Yes"' in signed_in(root).get("/admin/accounts/user/").text


def test_a_handover_that_tidies_says_so_and_how_long_it_may_take(robot, people, owned):
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.HANDOVER)
    robot.refresh_from_db()
    assert status_of(robot, SYSTEM.now()) == ("handover", "Being put back in order", "")
    for driver, words in (
        ("mercury", ""),
        ("puma", "it brings back what is elsewhere, which takes at most 3 min 20 s"),
    ):
        Robot.objects.filter(pk=robot.pk).update(driver=driver, settings={"tidy_s": 200})
        robot.refresh_from_db()
        state, _, why = status_of(robot, SYSTEM.now())
        assert state == "handover" and words in why and bool(words) == bool(why)
    with translation.override("de"):
        assert translate(why) == (
            "Der Roboter räumt für die nächste Runde auf: Er bringt zurück, was woanders liegt. Das dauert höchstens 3 min 20 s."
        )
