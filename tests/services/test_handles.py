"""Handles: one script, no invisible characters, unique, and not the name of a role or a robot."""

import pytest
from django.core.exceptions import ValidationError
from django.db import IntegrityError, connection, transaction
from django.db.migrations.executor import MigrationExecutor
from django.test import Client

from accounts import handles

pytestmark = pytest.mark.django_db
PASSWORDS = {"password1": "correct horse 42"}


@pytest.mark.service
@pytest.mark.parametrize("handle", ["ada", "Ada-Lovelace_2", "josé", "Åsa", "иван", "Ελένη", "さくらサクラ桜", "김철수", "नमस्ते", "أحمد", "x1"])  # fmt: skip
def test_handles(robot, handle):
    handles.validate(handle)


@pytest.mark.service
@pytest.mark.parametrize("handle", [
    "", "a", "x" * 25, "pаypal", "adа", "αda", "ad a", "ada\u200b", "a\u200dda", "ada\u202e", "\u3164\u3164", "\u115f\u115f", "a\0b",
    "ada\n", "a\u0336d\u0336a\u0336", "🤖🤖", "...", "12345", ".ada", "ada-", "a/b", "<b>", "admin", "Admin", "ＡＤＭＩＮ", "ad.min",
    "staff", "S-T-A-F-F", "admin1", "nobody", "Farhand", "mercury", "Mercury", "mer.cury", "\ud800\ud800", "ѕtаff",
    "5taff", "st4ff", "ádmin", "adm1n", "ＡＤＭ１Ｎ", "4dm1n7", "аԁміn", "ᴀᴅᴍɪɴ", "ꜱtaff", "ştaff", "rnercury", "r00t", "1staff", "fаrhапd", "syѕtem", "sʏstem",
])  # fmt: skip
def test_what_is_no_handle(robot, handle):
    if handle == "ada\n":
        handle = "a\nda"  # what stands around it is cut off
    with pytest.raises(ValidationError):
        handles.validate(handle)


LOOK_ALIKE = [
    ("alice", ["aIice", "alıce", "alíce", "a1ice", "ALICE", "Al1ce", "aⅼice", "alicé", "ɑlice", "ａlice", "ÁLÍCE", "a\u0301lice"]),
    ("bob", ["8ob", "b0b", "ВОВ", "вов", "ʙoʙ", "ɓob", "BOB", "bøb"]),
    ("anna", ["ΑΝΝΑ", "аnna", "ànnà", "ANNA"]),
    ("eve", ["ɛvɛ", "3v3", "ève"]),
    ("Łucja", ["lucja", "łucja", "1ucja"]),
    ("maks", ["макѕ", "rnaks", "MAKS"]),
    ("αννα", ["ΑΝΝΑ", "Αννα", "avva"]),
    ("иван", ["ИВАН", "йван"]),
]  # fmt: skip


@pytest.mark.service
@pytest.mark.parametrize("older, newer", [(older, one) for older, all_like in LOOK_ALIKE for one in all_like])
def test_what_looks_like_a_handle_is_taken_and_the_other_way_round(db, django_user_model, older, newer):
    for first, second in ((older, newer), (newer, older)):
        made = django_user_model.objects.create_user(handles.normal(first), "one@example.org", "x")
        assert handles.is_taken(second), (first, second)
        assert not handles.is_taken(second, but=made.pk)
        made.delete()


@pytest.mark.service
@pytest.mark.parametrize("one, other", [("ada", "adam"), ("कि", "कु"), ("がき", "かき"), ("김철수", "김철순"), ("أحمد", "محمد"), ("иван", "ирма"), ("tom", "tim"), ("eva", "ewa"), ("ไก", "กำ"), ("nina", "hina")])  # fmt: skip
def test_what_does_not_look_alike_is_another_name(one, other):
    assert handles.key(one) != handles.key(other)


@pytest.mark.service
def test_keys_are_the_skeletons_of_uts_39():
    """Pairs of Unicode's confusables.txt in each direction, several letters for one, and prototypes that are fixed."""
    for one, other in [
        ("m", "rn"),
        ("ӏ", "l"),
        ("ԝ", "w"),
        ("ø", "o"),
        ("ᴏ", "o"),
        ("ꭰ", "d"),
        ("ᎪᏞᏟᎬ", "ALCE"),
        ("ꓮꓢ", "AS"),
    ]:
        assert handles.key(one) == handles.key(other), (one, other)
    moved = {one: prototype for one, prototype in handles._prototypes().items() if one != prototype}
    assert len(moved) > 5000
    assert not {prototype for prototype in moved.values() if len(prototype) == 1} & set(moved), "it stands for itself"


def test_every_letter_has_a_key_that_can_be_kept():
    letters = [chr(n) for n in range(0x21, 0x10000) if chr(n).isalpha() and len(handles.normal(chr(n))) == 1]
    assert 0 < max(len(handles.key(30 * one)) for one in letters) < handles.LONGEST_KEY
    assert len(handles.key("\ufdfa" * 30)) <= handles.LONGEST_KEY


@pytest.mark.service
@pytest.mark.django_db(transaction=True)
def test_older_accounts_that_look_alike_stay_as_they_are(robot):
    before, after = [("accounts", "0007_help_texts")], [("accounts", "0008_look_alike_handles")]
    newest = MigrationExecutor(connection).loader.graph.leaf_nodes()
    try:
        MigrationExecutor(connection).migrate(before)
        old = MigrationExecutor(connection).loader.project_state(before).apps.get_model("accounts", "User")
        for n, (name, kept) in enumerate(
            [
                ("alice", "alice"),
                ("aIice", "aiice"),
                ("allce", "allce"),
                ("bob", "bob"),
                ("b0b", "b0b"),
                ("josé", "josé"),
            ]
        ):
            old.objects.create(pk=100 + n, username=f"{n}{n}", email=f"{n}@example.org")
            old.objects.filter(pk=100 + n).update(username=name, handle_key=kept)
        MigrationExecutor(connection).migrate(after)
        new = MigrationExecutor(connection).loader.project_state(after).apps.get_model("accounts", "User")
        found = dict(new.objects.filter(pk__gte=100).values_list("username", "handle_key"))
    finally:
        MigrationExecutor(connection).migrate(newest)
    assert found == {
        "alice": "allce", "aIice": "allce#101", "allce": "allce#102", "bob": "bob", "b0b": "bob#104", "josé": "jose",
    }  # fmt: skip


def sign_up(handle):
    return Client().post(
        "/accounts/signup/", {"email": f"n{abs(hash(handle))}@example.org", "username": handle, **PASSWORDS}
    )


@pytest.mark.service
@pytest.mark.parametrize("handle", ["ADA", "ａｄａ", "admin", "pаypal", "ada\u200b", "4d4", "áda", "ádmin", "5taff"])
def test_signing_up_refuses_with_a_sentence(people, handle):
    answer = sign_up(handle)
    assert answer.status_code == 200
    assert b"errorlist" in answer.content
    assert b"letters of one script" in answer.content, "the rules stand at the field"


@pytest.mark.service
def test_a_new_handle_is_kept_in_its_normal_form(people, django_user_model):
    assert sign_up("Ｇｒａｃｅ").status_code == 302
    assert django_user_model.objects.get(username="Grace").handle_key == "grace"
    assert sign_up("GRACE").status_code == 200
    assert sign_up("сосо").status_code == 302
    assert sign_up("coco").status_code == 200, "it looks like the Cyrillic one"


@pytest.mark.service
def test_the_database_refuses_a_handle_that_looks_the_same(people, django_user_model):
    with pytest.raises(IntegrityError), transaction.atomic():
        django_user_model.objects.create_user("ADA", "other@example.org", "x")


@pytest.mark.service
def test_older_accounts_keep_theirs_in_the_admin(people, client, admin_user):
    client.force_login(admin_user)
    page = f"/admin/accounts/user/{admin_user.pk}/change/"
    data = {
        "username": "admin", "email": "admin@example.org", "is_active": "on", "is_staff": "on", "is_superuser": "on",
        "date_joined_0": "2026-01-01", "date_joined_1": "00:00:00", "first_name": "Kept", "turn_factor": 1,
    }  # fmt: skip
    assert client.post(page, data).status_code == 302
    admin_user.refresh_from_db()
    assert admin_user.first_name == "Kept"
    assert b"reserved" in client.post(page, data | {"username": "staff"}).content
    assert b"looks like one" in client.post(page, data | {"username": "ADA"}).content


@pytest.mark.service
def test_an_account_from_before_with_a_shared_key_can_be_saved(people, django_user_model):
    old = people["bob"]
    django_user_model.objects.filter(pk=old.pk).update(username="Ada", handle_key=f"ada#{old.pk}")
    old.refresh_from_db()
    old.save()
    old.refresh_from_db()
    assert old.handle_key == f"ada#{old.pk}"
    people["ada"].delete()
    assert handles.is_taken("4da"), "the other still looks like that"


@pytest.mark.service
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
    }
    answer = client.post("/accounts/signup/", data, follow=True)
    assert answer.status_code == 200
    assert b"Somebody has just taken that handle" in answer.content
    assert django_user_model.objects.filter(username="quick").count() == 1
