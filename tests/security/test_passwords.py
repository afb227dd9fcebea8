"""What a password may be, where it is asked for, what a session is."""

import re

import pytest
from allauth.account.models import EmailAddress
from django.contrib.auth.password_validation import validate_password
from django.core import mail
from django.core.exceptions import ValidationError
from django.test import Client

pytestmark = pytest.mark.django_db
GOOD = "seven Blue kites over Haarlem"


@pytest.fixture
def ada(people):
    """Ada, whose address is confirmed."""
    EmailAddress.objects.create(user=people["ada"], email="ada@example.org", verified=True, primary=True)
    return people["ada"]


@pytest.mark.asvs("6.2.1", "6.2.4", "6.2.11")
@pytest.mark.parametrize(
    "bad", ["Ab1!xyz", "password123", "qwertyuiop", "12345678901", "adalovelace1", "farhand-robot"]
)
def test_weak_passwords_are_refused(django_user_model, bad):
    person = django_user_model(username="adalovelace", email="ada@example.org")
    with pytest.raises(ValidationError):
        validate_password(bad, person)


@pytest.mark.asvs("6.2.5", "6.2.8", "6.2.9")
@pytest.mark.parametrize("good", [GOOD, "x" * 20 + "jumping otters " * 5, "zażółć gęślą jaźń", " spaces count too "])
def test_any_kind_of_long_password_is_taken_as_typed(django_user_model, client, good):
    validate_password(good, django_user_model(username="ada", email="ada@example.org"))
    person = django_user_model.objects.create_user("ada", "ada@example.org", good)
    assert person.check_password(good)
    assert not person.check_password(good.strip() + "!")
    assert not person.check_password(good.swapcase())


@pytest.mark.asvs("6.2.6", "6.2.7", "6.4.2")
@pytest.mark.parametrize("page", ["/accounts/login/", "/accounts/signup/"])
def test_password_fields_are_masked_and_take_a_paste(client, page):
    html = client.get(page).content.decode()
    fields = re.findall(r"<input[^>]*name=\"password\d?\"[^>]*>", html)
    assert fields
    for field in fields:
        assert 'type="password"' in field
        assert "autocomplete=" in field
        assert 'autocomplete="off"' not in field
        assert "onpaste" not in field
    assert "secret question" not in html.lower()


@pytest.mark.asvs("6.2.2", "6.2.3", "7.4.3")
def test_a_changed_password_wants_the_present_one_and_ends_the_other_sessions(ada, client):
    here, elsewhere = client, Client()
    for one in (here, elsewhere):
        assert one.post("/accounts/login/", {"login": "ada", "password": "correct horse 42"}).status_code == 302
    wrong = {"oldpassword": "not it at all", "password1": GOOD, "password2": GOOD}
    here.post("/accounts/password/change/", wrong)
    assert elsewhere.get("/me/").status_code == 200
    here.post("/accounts/password/change/", {**wrong, "oldpassword": "correct horse 42"})
    ada.refresh_from_db()
    assert ada.check_password(GOOD)
    assert elsewhere.get("/me/").status_code == 302


@pytest.mark.asvs("7.2.2", "7.2.3", "7.2.4")
def test_signing_in_makes_a_new_session_key(ada, client):
    client.get("/accounts/login/")
    session = client.session
    session["planted"] = "by a stranger"
    session.save()
    before = session.session_key
    client.cookies["sessionid"] = before
    client.post("/accounts/login/", {"login": "ada", "password": "correct horse 42"})
    after = client.cookies["sessionid"].value
    assert after != before
    assert len(after) >= 32
    assert not client.session.__class__().exists(before)


@pytest.mark.asvs("7.4.1", "7.2.1", "7.4.4")
def test_signing_out_ends_the_session_on_the_server(ada, client):
    client.post("/accounts/login/", {"login": "ada", "password": "correct horse 42"})
    assert "/accounts/logout/" in client.get("/log/").content.decode()
    key = client.cookies["sessionid"].value
    client.get("/accounts/logout/")
    assert client.get("/me/").status_code == 200, "an address alone signs nobody out"
    client.post("/accounts/logout/")
    client.cookies["sessionid"] = key
    assert client.get("/me/").status_code == 302


@pytest.mark.asvs("7.4.2")
def test_a_deactivated_person_has_no_session(ada, client):
    client.force_login(ada)
    ada.is_active = False
    ada.save()
    assert client.get("/me/").status_code == 302


@pytest.mark.asvs("6.4.3", "6.5.1", "6.5.3", "6.5.4", "6.6.2")
def test_a_mailed_link_resets_a_password_once(ada, client, settings):
    settings.EMAIL_BACKEND = "django.core.mail.backends.locmem.EmailBackend"
    client.post("/accounts/password/reset/", {"email": "ada@example.org"})
    link = re.search(r"/accounts/password/reset/key/\S+", mail.outbox[-1].body)[0]
    token = link.rstrip("/").split("-", 1)[1]
    assert len(token) >= 32
    form = client.get(link, follow=True)
    where = form.redirect_chain[-1][0]
    assert token not in where, "the token is not left in the address"
    client.post(where, {"password1": GOOD, "password2": GOOD})
    ada.refresh_from_db()
    assert ada.check_password(GOOD)
    client.logout()
    again = client.get(link, follow=True).content.decode()
    assert 'name="password1"' not in again


@pytest.mark.asvs("6.3.2", "6.4.1", "13.2.3")
def test_promise_42_the_first_account_has_a_password_that_nobody_knows(django_user_model):
    from portal.keep.seeding import seed

    with pytest.raises(django_user_model.DoesNotExist):
        django_user_model.objects.get(username="admin")
    password = seed()
    assert len(password) >= 16
    admin = django_user_model.objects.get()
    assert admin.check_password(password)
    assert not any(admin.check_password(word) for word in ("", "admin", "farhand", "password", "changeme"))
    django_user_model.objects.all().delete()
    assert seed() != password
    assert seed() is None, "it is told once"


@pytest.mark.asvs("8.2.3", "15.3.3")
def test_staff_who_change_people_give_nobody_rights(people, client, django_user_model):
    from django.contrib.auth.models import Permission

    kim, eve = people["kim"], people["eve"]
    kim.user_permissions.add(*Permission.objects.filter(codename__in=["change_user", "view_user"]))
    client.force_login(django_user_model.objects.get(pk=kim.pk))
    form = client.get(f"/admin/accounts/user/{eve.pk}/change/")
    assert form.status_code == 200
    data = {"username": "eve", "email": "eve@example.org", "is_active": "on", "is_superuser": "on", "is_staff": "on"}
    client.post(f"/admin/accounts/user/{eve.pk}/change/", {**data, "user_permissions": ["1", "2"]})
    client.post(f"/admin/accounts/user/{kim.pk}/change/", {**data, "username": "kim", "email": "kim@example.org"})
    for person in (eve, kim):
        person.refresh_from_db()
        assert not person.is_superuser
    assert not eve.is_staff
    assert not eve.user_permissions.exists()
