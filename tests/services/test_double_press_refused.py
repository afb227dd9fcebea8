"""A refused form does not count as a first press: the same form works when it is allowed; strangers leave no rows."""

import pytest
from django.core.cache import cache
from django.test import Client

from robots.models import Command, Grant, Robot
from robots.states import Cycle
from tests.services.press_forms import World, account, address, job_of_a_guest
from tests.services.press_forms_admin import VERBS_ONCE, maintenance

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]


@pytest.fixture
def world(robot, people, clock, owned):
    return World(robot, people, clock)


@pytest.fixture
def keys(monkeypatch):
    """The keys under which first presses are remembered."""
    seen, add = [], cache.add
    monkeypatch.setattr(cache, "add", lambda key, *rest, **more: (seen.append(key), add(key, *rest, **more))[1])
    return lambda: [key for key in seen if key.startswith("once:")]


@pytest.mark.parametrize("made", [*VERBS_ONCE.values(), address], ids=lambda made: made.__name__)
def test_who_has_to_sign_in_first_presses_again_afterwards(world, made, keys):
    form = made(world)
    stranger = Client().post(form.address, form.data)
    assert "/login/" in stranger["Location"]
    assert not keys()
    assert "/login/" not in form.press()[1]
    assert form.made() == form.counts


def test_a_verb_that_was_refused_is_carried_out_when_it_may_be(world):
    form = maintenance(world)
    Robot.objects.update(cycle=Cycle.READY)
    form.press()
    assert not Grant.objects.exists()
    Robot.objects.update(cycle=Cycle.LOCKED_OUT)
    form.press()
    assert form.made() == form.counts


def test_what_one_person_made_is_not_made_by_another(world):
    form = VERBS_ONCE["procedure"](world)
    form.press()
    Grant.objects.update(ended_at="2026-01-01T00:00Z")
    Command.objects.update(state="done")
    other = world.people["bob"]
    other.is_staff = True
    other.save()
    other.user_permissions.set(world.people["kim"].user_permissions.all())
    form.cookies = world.browser("bob").cookies
    form.press()
    assert {one.issued_by for one in Command.objects.all()} == {world.people["kim"], other}


@pytest.mark.parametrize("made", [account])
def test_a_form_of_another_site_learns_nothing(world, made):
    form = made(world)
    form.press()
    answer = Client(enforce_csrf_checks=True).post(form.address, form.data)
    assert (answer.status_code, answer.get("Location")) == (403, None)


def test_strangers_leave_nothing_where_nothing_is_made(shuttle, people, clock, keys):
    form = job_of_a_guest(World(shuttle, people, clock))
    page = form.press()[1]
    told = {"once": "x" * 30}
    for where, data in (("/me/", {}), ("/", {}), ("/me/places/", {"do": "join"}), (page, {"do": "seen"}), (page, {})):
        Client().post(where, {**data, **told})
    assert not keys()
    assert Client().post(page, {"do": "survey", **told}).status_code == 403
    assert [cache.get(key) for key in keys()] == [None]
