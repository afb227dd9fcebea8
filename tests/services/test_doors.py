"""Signing in at two addresses, signing up and asking for mails, from an attacker's side."""

import os
import subprocess
import sys

import pytest
from django.core.cache import cache
from django.test import Client

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.timed, pytest.mark.usefixtures("one_count")]
LOGIN, WRONG = "/accounts/login/", "wrong horse 13"


@pytest.fixture(autouse=True)
def fresh():
    cache.clear()
    yield
    cache.clear()


def sign_in(name, password, address="192.0.2.1", door=LOGIN):
    return Client(REMOTE_ADDR=address).post(door, {"login": name, "password": password})


def let_in(answer):
    return answer.status_code == 302


@pytest.mark.asvs("6.1.1", "6.3.1", "6.3.4")
def test_five_wrong_passwords_close_the_door_for_that_account_from_that_address(people):
    for _ in range(5):
        assert not let_in(sign_in("ada", WRONG))
    answer = sign_in("ada", "correct horse 42")
    assert not let_in(answer)
    assert b"Too many failed login attempts" in answer.content
    assert not let_in(sign_in("ADA@example.org", "correct horse 42")), "both names of an account share one count"
    assert let_in(sign_in("bob", "correct horse 42")), "another account from there is not closed"
    assert let_in(sign_in("ada", "correct horse 42", "192.0.2.2")), "nobody is locked out by somebody elsewhere"


def test_one_address_tries_many_names_in_vain(people):
    for number in range(10):
        sign_in(f"name{number}", WRONG)
    assert not let_in(sign_in("ada", "correct horse 42"))
    assert let_in(sign_in("ada", "correct horse 42", "192.0.2.2"))


@pytest.mark.asvs("6.3.1")
def test_addresses_of_one_ipv6_network_count_as_one(people):
    for number in range(10):
        sign_in(f"name{number}", WRONG, f"2001:db8:1:2::{number + 1:x}")
    assert not let_in(sign_in("ada", "correct horse 42", "2001:db8:1:2:ffff::1"))
    assert let_in(sign_in("ada", "correct horse 42", "2001:db8:1:3::1"))


@pytest.mark.asvs("4.1.3", "15.3.4")
def test_what_a_client_says_of_its_address_changes_nothing(people):
    for number in range(5):
        Client(REMOTE_ADDR="192.0.2.1", HTTP_X_FORWARDED_FOR=f"198.51.100.{number}").post(
            LOGIN, {"login": "ada", "password": WRONG}
        )
    assert not let_in(sign_in("ada", "correct horse 42"))


@pytest.mark.asvs("6.3.1", "6.3.4")
def test_the_admin_has_no_door_of_its_own(people):
    for data in ({"username": "kim", "password": "correct horse 42"}, {"login": "kim", "password": WRONG}):
        client = Client()
        answer = client.post("/admin/login/?next=/admin/", data)
        assert (answer.status_code, answer["Location"].split("?")[0]) == (302, LOGIN)
        assert client.get("/admin/").status_code == 302, "nobody is signed in by it"
    answer = Client().post(f"{LOGIN}?next=/admin/", {"login": "kim", "password": "correct horse 42"})
    assert answer["Location"] == "/admin/" or "confirm-email" in answer["Location"]


@pytest.mark.asvs("6.6.3")
@pytest.mark.parametrize("url, data, times", [
    ("/accounts/signup/", {"password1": "x"}, 10), ("/accounts/password/reset/", {"email": "n{}@example.org"}, 10),
])  # fmt: skip
def test_other_doors_close_too(db, url, data, times):
    statuses = [
        Client(REMOTE_ADDR="192.0.2.1").post(url, {k: v.format(n) for k, v in data.items()}).status_code
        for n in range(times + 1)
    ]
    assert 429 not in statuses[:-1]
    assert statuses[-1] == 429


@pytest.mark.asvs("2.4.1")
def test_reset_mails_to_one_person_are_few_wherever_they_are_asked_for(people, mailoutbox):
    for number in range(8):
        Client(REMOTE_ADDR=f"192.0.2.{number + 1}").post("/accounts/password/reset/", {"email": "ada@example.org"})
    assert len(mailoutbox) == 3


COUNT = """
import django; django.setup()
from django.conf import settings
# a busy Redis that answered late would split the count
settings.CACHES["default"]["OPTIONS"].update(socket_timeout=30, socket_connect_timeout=30)
from django.test import RequestFactory
from allauth.core import ratelimit
from django.contrib.auth.models import AnonymousUser
request = RequestFactory().post("/", REMOTE_ADDR="203.0.113.77")
request.user = AnonymousUser()
from allauth.core.internal import ratelimit
print(sum(bool(ratelimit.consume(request, app="allauth.account", action="signup")) for _ in range(6)))
"""


def counted_elsewhere():
    env = {**os.environ, "DJANGO_SETTINGS_MODULE": "portal.settings", "PYTHONPATH": "."}
    done = subprocess.run([sys.executable, "-c", COUNT], env=env, capture_output=True, text=True, check=True)
    return int(done.stdout)


@pytest.mark.asvs("6.3.1", "6.3.4")
def test_two_processes_share_one_count(redis_server):
    assert [counted_elsewhere(), counted_elsewhere()] == [6, 4]


@pytest.mark.asvs("6.3.1", "6.3.4")
def test_without_redis_limits_hold_in_each_process_and_no_page_fails(people, redis_server):
    redis_server.stop()
    try:
        for _ in range(5):
            assert sign_in("ada", WRONG).status_code == 200
        assert not let_in(sign_in("ada", "correct horse 42"))
    finally:
        redis_server.start()


def answers(client, data):
    from django.contrib.auth import hashers
    from django.db import connection
    from django.test.utils import CaptureQueriesContext

    hashed = []
    real = hashers.MD5PasswordHasher.encode
    hashers.MD5PasswordHasher.encode = lambda self, *a, **k: hashed.append(1) or real(self, *a, **k)
    try:
        with CaptureQueriesContext(
            connection,
        ) as asked:
            answer = client.post("/accounts/signup/", data)
    finally:
        hashers.MD5PasswordHasher.encode = real
    page = client.get(answer["Location"])
    inserts = sum(q["sql"].startswith("INSERT") for q in asked.captured_queries)
    return answer.status_code, answer["Location"], page.content, len(hashed), inserts


def test_promise_38_signing_up_does_the_same_work_for_a_known_address(people, mailoutbox):
    from allauth.account.models import EmailAddress

    EmailAddress.objects.create(user=people["ada"], email="ada@example.org", verified=True, primary=True)
    data = {"password1": "correct horse 42"}
    known = answers(Client(), data | {"email": "ada@example.org", "username": "newone"})
    fresh = answers(Client(), data | {"email": "new@example.org", "username": "newtwo"})
    assert known[:2] == fresh[:2]
    assert known[3:] == fresh[3:], "as many passwords hashed and rows written"
    assert known[3] >= 1
    assert known[2].replace(b"ada@", b"new@") == fresh[2]
    assert [m.to for m in mailoutbox] == [["ada@example.org"], ["new@example.org"]]
    assert not type(people["ada"]).objects.filter(username="newone").exists()


def test_promise_38_signing_in_hashes_one_password_whoever_it_is(people, monkeypatch):
    from allauth.account.models import EmailAddress
    from django.contrib.auth import hashers

    EmailAddress.objects.create(user=people["ada"], email="ada@example.org", verified=True, primary=True)
    hashed = []
    real = hashers.MD5PasswordHasher.encode
    monkeypatch.setattr(
        hashers.MD5PasswordHasher, "encode", lambda self, *a, **k: hashed.append(1) or real(self, *a, **k)
    )
    for number, name in enumerate(("ada", "ada@example.org", "nobody", "nobody@example.org", "ADA", "a" * 200)):
        hashed.clear()
        sign_in(name, WRONG, f"192.0.2.{number + 1}")
        assert len(hashed) == 1, name
    hashed.clear()
    assert let_in(sign_in("ada@example.org", "correct horse 42", "192.0.2.99"))
    assert len(hashed) == 1
