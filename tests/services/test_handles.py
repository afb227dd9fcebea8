"""Handles: one script, no invisible characters, unique, and not the name of a role or a robot."""

import pytest
from django.core.exceptions import ValidationError
from django.db import IntegrityError, transaction
from django.test import Client

from accounts import handles

pytestmark = [pytest.mark.service, pytest.mark.django_db]
PASSWORDS = {"password1": "correct horse 42", "password2": "correct horse 42"}


@pytest.mark.parametrize("handle", ["ada", "Ada-Lovelace_2", "josé", "Åsa", "иван", "Ελένη", "さくらサクラ桜", "김철수", "नमस्ते", "أحمد", "x1"])  # fmt: skip
def test_handles(robot, handle):
    handles.validate(handle)


@pytest.mark.parametrize("handle", [
    "", "a", "x" * 25, "pаypal", "adа", "αda", "ad a", "ada\u200b", "a\u200dda", "ada\u202e", "\u3164\u3164", "\u115f\u115f", "a\0b",
    "ada\n", "a\u0336d\u0336a\u0336", "🤖🤖", "...", "12345", ".ada", "ada-", "a/b", "<b>", "admin", "Admin", "ＡＤＭＩＮ", "ad.min",
    "staff", "S-T-A-F-F", "admin1", "nobody", "Farhand", "mercury", "Mercury", "mer.cury", "\ud800\ud800", "ѕtаff",
])  # fmt: skip
def test_what_is_no_handle(robot, handle):
    if handle == "ada\n":
        handle = "a\nda"  # what stands around it is cut off
    with pytest.raises(ValidationError):
        handles.validate(handle)


def sign_up(handle):
    return Client().post(
        "/accounts/signup/", {"email": f"n{abs(hash(handle))}@example.org", "username": handle, **PASSWORDS}
    )


@pytest.mark.parametrize("handle", ["ADA", "ａｄａ", "admin", "pаypal", "ada\u200b"])
def test_signing_up_refuses_with_a_sentence(people, handle):
    answer = sign_up(handle)
    assert answer.status_code == 200
    assert b"errorlist" in answer.content
    assert b"letters of one script" in answer.content, "the rules stand at the field"


def test_a_new_handle_is_kept_in_its_normal_form(people, django_user_model):
    assert sign_up("Ｇｒａｃｅ").status_code == 302
    assert django_user_model.objects.get(username="Grace").handle_key == "grace"
    assert sign_up("GRACE").status_code == 200
    assert sign_up("сосо").status_code == 302
    assert sign_up("coco").status_code == 200, "it looks like the Cyrillic one"


def test_the_database_refuses_a_handle_that_looks_the_same(people, django_user_model):
    with pytest.raises(IntegrityError), transaction.atomic():
        django_user_model.objects.create_user("ADA", "other@example.org", "x")


def test_older_accounts_keep_theirs_in_the_admin(people, client, admin_user):
    client.force_login(admin_user)
    page = f"/admin/accounts/user/{admin_user.pk}/change/"
    data = {
        "username": "admin", "email": "admin@example.org", "is_active": "on", "is_staff": "on", "is_superuser": "on",
        "date_joined_0": "2026-01-01", "date_joined_1": "00:00:00", "first_name": "Kept",
    }  # fmt: skip
    assert client.post(page, data).status_code == 302
    admin_user.refresh_from_db()
    assert admin_user.first_name == "Kept"
    assert b"reserved" in client.post(page, data | {"username": "staff"}).content
    assert b"looks like one" in client.post(page, data | {"username": "ADA"}).content


def test_an_account_from_before_with_a_shared_key_can_be_saved(people, django_user_model):
    old = people["bob"]
    django_user_model.objects.filter(pk=old.pk).update(username="Ada", handle_key=f"ada#{old.pk}")
    old.refresh_from_db()
    old.save()
    old.refresh_from_db()
    assert old.handle_key == f"ada#{old.pk}"


def test_a_handle_that_somebody_takes_in_the_same_moment_is_told_in_words(client, django_user_model, monkeypatch):
    from accounts.forms import SignupForm

    whole = SignupForm.clean

    def slow(self):
        found = whole(self)
        django_user_model.objects.create_user("quick", "quick@example.org", "correct horse 42")
        return found

    monkeypatch.setattr(SignupForm, "clean", slow)
    data = {
        "username": "quick",
        "email": "late@example.org",
        "password1": "correct horse 42",
        "password2": "correct horse 42",
    }
    answer = client.post("/accounts/signup/", data, follow=True)
    assert answer.status_code == 200
    assert b"Somebody has just taken that handle" in answer.content
    assert django_user_model.objects.filter(username="quick").count() == 1
