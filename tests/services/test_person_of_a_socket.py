"""The person behind a socket, read again for every request: in one statement, and no later than Django would notice."""

from datetime import timedelta

import pytest
from django.conf import settings
from django.contrib.sessions.models import Session

from portal.live.people import current_user
from robots.kit.clock import SYSTEM
from tests.services.browsers import signed_in

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def signed(people):
    """Return a client in which ada is signed in, and the scope of a socket whose person was read before."""
    client = signed_in(people["ada"])
    scope = {"cookies": {settings.SESSION_COOKIE_NAME: client.cookies[settings.SESSION_COOKIE_NAME].value}}
    assert current_user(scope) == people["ada"]
    return client, scope


def test_the_same_person_again_costs_one_statement(signed, people, django_assert_num_queries):
    with django_assert_num_queries(1):
        found = current_user(signed[1])
    assert (found, found.username, found.is_authenticated) == (people["ada"], "ada", True)


def signed_out(client, person):
    client.logout()


def new_password(client, person):
    person.set_password("another one 43")
    person.save()


def switched_off(client, person):
    person.is_active = False
    person.save()


def deleted(client, person):
    person.delete()


def run_out(client, person):
    Session.objects.update(expire_date=SYSTEM.now() - timedelta(seconds=1))


def forged(client, person):
    row = Session.objects.get()
    Session.objects.update(session_data=("A" if row.session_data[0] != "A" else "B") + row.session_data[1:])


def by_a_backend_no_longer_used(client, person):
    settings.AUTHENTICATION_BACKENDS = ["django.contrib.auth.backends.RemoteUserBackend"]


@pytest.mark.parametrize(
    "change", [signed_out, new_password, switched_off, deleted, run_out, forged, by_a_backend_no_longer_used]
)
def test_nobody_is_signed_in_any_more(signed, people, change, monkeypatch):
    client, scope = signed
    monkeypatch.setattr(settings, "AUTHENTICATION_BACKENDS", settings.AUTHENTICATION_BACKENDS)
    change(client, people["ada"])
    for _ in range(2):
        assert not current_user(scope).is_authenticated


def test_a_session_that_now_belongs_to_another_person_is_theirs(signed, people):
    _, scope = signed
    other = signed_in(people["bob"])
    taken = Session.objects.get(pk=other.cookies[settings.SESSION_COOKIE_NAME].value)
    Session.objects.filter(pk=scope["cookies"][settings.SESSION_COOKIE_NAME]).update(session_data=taken.session_data)
    assert current_user(scope) == people["bob"]
    assert current_user(scope) == people["bob"]


@pytest.mark.parametrize("key", ["", "\x00", "x" * 40, "' or 1=1 --"])
def test_a_key_that_is_none_finds_nobody(people, key):
    scope = {"cookies": {settings.SESSION_COOKIE_NAME: key}, "farhand.person": people["ada"].pk}
    assert not current_user(scope).is_authenticated
