"""Every form that makes something is sent twice, one after the other and at once: it makes one thing.

The second press is answered as the first. A fresh form makes another one.
"""

import re
import threading
from concurrent.futures import ThreadPoolExecutor
from http.cookies import SimpleCookie

import pytest
from django.contrib import admin
from django.core import mail
from django.test import Client, RequestFactory
from django.urls import URLPattern, get_resolver

from queueing.models import Job
from robots.admin.verbs import VERBS
from tests.services.press_forms import (
    World,
    accepted_offer,
    account,
    address,
    answers_of_a_turn,
    entry,
    entry_with_answers,
    failed_test,
    job_of_a_guest,
    job_of_a_person,
    job_of_a_script,
    movie,
    orientation_read,
    passed_test,
    place,
    place_in_the_classic_console,
    program,
    push_subscription,
    shared_program,
    survey_of_a_job,
    time_lapse,
)  # fmt: skip
from tests.services.press_forms_admin import NEW, NEW_ROWS, VERBS_ONCE
from tests.waiting import CEILING_S

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
PRESSES = 4

OF_JOBS = (job_of_a_person, job_of_a_guest, job_of_a_script, survey_of_a_job)
OTHERS = (
    entry, entry_with_answers, answers_of_a_turn, program, shared_program, failed_test, passed_test, orientation_read,
    place, accepted_offer, place_in_the_classic_console, movie, time_lapse, account, address, push_subscription, *NEW_ROWS, *VERBS_ONCE.values(),
)  # fmt: skip


@pytest.fixture
def world(request, robot, people, clock, settings, tmp_path):
    settings.MEDIA_ROOT = tmp_path / "media"
    request.getfixturevalue("shuttle" if request.node.callspec.params["made"] in OF_JOBS else "owned")
    return World(robot, people, clock)


each_form = pytest.mark.parametrize("made", OF_JOBS + OTHERS, ids=lambda made: made.__name__)


@each_form
def test_one_press_after_the_other_makes_one_thing(world, made):
    form = made(world)
    before = form.made()
    first = form.press()
    mails = len(mail.outbox)
    assert form.made() == form.counts
    assert made is failed_test or form.counts != before
    assert [form.press(), form.press()] == [first] * 2
    assert form.made() == form.counts
    assert len(mail.outbox) == mails


@each_form
def test_presses_at_once_make_one_thing(world, made):
    form = made(world)
    together = threading.Barrier(PRESSES)

    def press(_):
        together.wait(CEILING_S)
        return form.press()

    with ThreadPoolExecutor(PRESSES) as pool:
        answers = list(pool.map(press, range(PRESSES)))
    assert answers == answers[:1] * PRESSES
    assert form.made() == form.counts


@pytest.mark.parametrize("made", [job_of_a_person])
def test_a_fresh_form_makes_another_job_and_so_does_another_value_in_the_same(world, made):
    for number in (1, 2):
        made(world).press()
        assert Job.objects.count() == number
    form = made(world)
    form.press()
    form.data["arg-x"] = "0.5"  # gone back, and filled in anew
    form.press()
    assert Job.objects.count() == 4


@pytest.mark.parametrize("made", [job_of_a_guest])
def test_both_presses_of_a_guest_are_of_one_guest_whichever_answer_is_read(world, made):
    form = made(world)
    guests = []
    for _ in range(2):
        client = Client()
        client.cookies = SimpleCookie(form.cookies.output(header="", sep=";"))
        client.post(form.address, form.data)
        guests.append(client)
    job = Job.objects.get()
    for guest in guests:
        assert "Cancel this job" in guest.get(job.get_absolute_url()).content.decode()
    assert "Cancel this job" not in Client().get(job.get_absolute_url()).content.decode()
    token = form.data["press"]
    assert token not in (job.guest, job.form), "the database has no secret of a guest"


@pytest.mark.parametrize("made", [job_of_a_guest])
def test_no_cache_makes_two_strangers_one_guest(world, made):
    """The token that a page shows becomes the guest's cookie."""
    form = made(world)
    for page in (Client().get(form.address), Client().post(form.address, {"kind": "none"})):
        assert 'name="press"' in page.content.decode()
        assert {"no-store", "private"} <= set(page["Cache-Control"].split(", "))


@pytest.mark.parametrize("made", [account])
def test_a_form_that_was_refused_is_carried_out_when_it_is_right(world, made):
    form = made(world)
    good = dict(form.data)
    form.data["password1"] = "12345678"
    assert form.press()[0] == 200, "shown again, with what is wrong"
    form.data = good
    assert form.press()[0] == 302
    assert form.made() == form.counts


@pytest.mark.parametrize("made", [account])
def test_a_demo_shows_the_link_to_confirm_after_a_double_press(world, made, settings, capfd):
    settings.EMAIL_BACKEND = "django.core.mail.backends.console.EmailBackend"
    form = made(world)
    form.press()
    client = Client()
    client.cookies = SimpleCookie(form.cookies.output(header="", sep=";"))
    shown = client.post(form.address, form.data, follow=True).content.decode()
    assert "Confirm my address" in shown


MAKES_NOTHING = {
    # reads only
    "landing", "drive", "story", "status", "me", "push-worker", "robot", "model", "orientation-picture", "statistics", "statistics-json", "composite", "camera",
    "snapshot", "shot", "movie-of-the-day", "recordings", "recording", "recording-file", "recording-index", "recording-part", "classic",
    "recording-picture", "embed-recording", "embed-robot", "oembed", "daily", "daily-json", "daily-csv", "classic-picture", "log", "log-feed", "status-feed", "robot-log-feed", "robot-status-feed", "finds", "dug", "survey-results", "survey-csv", "texts", "media", "favicon.ico", "livez", "readyz",
    "recordings/<str:key>/movie.mp4", "recordings/<str:key>/movie.webm",
    "robots/<slug:slug>/time-lapse/<str:day>.mp4", "robots/<slug:slug>/time-lapse/<str:day>.webm",
    # sets a choice, again and again the same
    "alerts", "choices", "language",
    # a guest, who is removed after a day, and of whom a network address has a limit
    "practise",
    # a code for one stream of an operator, which lasts for half a minute
    "stream-code",
    # of accounts: what is there is changed, or a mail is sent, of which there is a limit
    "account_login", "account_logout", "account_inactive", "account_reauthenticate", "account_change_password",
    "account_set_password", "account_confirm_email", "send-again", "account_email_verification_sent", "account_reset_password",
    "account_reset_password_done", "account_reset_password_from_key", "account_reset_password_from_key_done",
    "account_confirm_login_code",
}  # fmt: skip
MAKES = {
    "places": (place, accepted_offer), "push": (push_subscription,), "programs": (program, shared_program), "orientation": (orientation_read,),
    "clearance": (failed_test, passed_test), "jobs": (job_of_a_person, job_of_a_guest, job_of_a_script),
    "job": (survey_of_a_job,), "ask-lapse": (time_lapse,), "ask-movie": (movie,),
    "classic-page": (place_in_the_classic_console,), "turn": (entry, entry_with_answers, answers_of_a_turn),
    "account_signup": (account,), "account_email": (address,), "admin": (*NEW_ROWS, *VERBS_ONCE.values()),
}  # fmt: skip


def names(patterns):
    for one in patterns:
        if isinstance(one, URLPattern):
            yield one.name or str(one.pattern)
        elif one.namespace:
            yield one.namespace
        else:
            yield from names(one.url_patterns)


def test_each_address_is_decided_on():
    """An author who adds an address says here whether a form that is sent to it makes something."""
    assert set(names(get_resolver().url_patterns)) == MAKES_NOTHING | MAKES.keys()
    assert {one for made in MAKES.values() for one in made} == {*OF_JOBS, *OTHERS}


def test_each_form_of_the_admin_is_decided_on(admin_user):
    """An author who adds a page for new rows, or a verb, says here what it makes."""
    request = RequestFactory().get("/admin/")
    request.user = admin_user
    assert {model for model, page in admin.site._registry.items() if page.has_add_permission(request)} == NEW.keys()
    assert VERBS.keys() == VERBS_ONCE.keys() | {
        "enable", "disable", "stop", "release", "lock_out", "lift", "end_maintenance", "resume_jobs",
    }  # fmt: skip


def test_what_stops_or_bars_a_robot_is_carried_out_at_each_press(robot, people, client):
    """Pages to which somebody goes back send again what their form says."""
    client.force_login(people["kim"])
    html = client.get(f"/admin/robots/robot/{robot.pk}/change/").content.decode()
    forms = {re.search(r"/do/(\w+)/", one)[1]: one for one in re.findall(r"<form[^>]*/do/.*?</form>", html, re.DOTALL)}
    assert {verb for verb, form in forms.items() if 'name="once"' in form} == {"test", "procedure", "setting"}
    assert {"stop", "disable", "lock_out"} <= forms.keys()
