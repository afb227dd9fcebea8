"""Every form that makes something is sent twice, one after the other and at once: it makes one thing.

The second press is answered as the first. A fresh form makes another one.
"""

import json
import re
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from datetime import timedelta
from http.cookies import SimpleCookie

import pytest
from allauth.account.models import EmailAddress
from django.core import mail
from django.db import connection
from django.test import Client
from django.urls import URLPattern, get_resolver

from accounts import services as accounts
from accounts.bank import load_bank
from accounts.models import Attempt, Choice, Clearance, OrientationRead, User
from operatorlog.models import Entry, SurveyAnswer, SurveyQuestion, SurveyResponse
from queueing import services as queue
from queueing.models import Job, Ticket, Turn
from robots.clock import SYSTEM
from robots.models import Command, Frame, Grant, Movie, Program
from robots.recordings import keeping
from robots.states import GrantEnd
from tests.waiting import CEILING_S

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
SECRET = "correct horse 42"
PRESSES = 4


@dataclass
class Form:
    """A form as a browser has it: where it goes, what is in it, what the browser's cookies are, and what it makes."""

    address: str
    data: object
    counts: dict
    cookies: SimpleCookie = field(default_factory=SimpleCookie)
    more: dict = field(default_factory=dict)

    def press(self, _=None):
        """Send it as a browser does that has no answer yet; return what tells one answer from another."""
        client = Client()
        client.cookies = SimpleCookie(self.cookies.output(header="", sep=";"))
        try:
            answer = client.post(self.address, self.data, **self.more)
        finally:
            connection.close() if threading.current_thread() is not threading.main_thread() else None
        assert answer.status_code < 400, answer.content.decode()[-3000:]
        body = answer.json() if "json" in answer["Content-Type"] else None
        return answer.status_code, answer.get("Location"), body

    def made(self):
        """Return how many rows there are of what it makes."""
        return {model: model.objects.count() for model in self.counts}


class World:
    """What the forms are about."""

    def __init__(self, robot, people, clock):
        self.robot, self.people, self.clock = robot, people, clock

    def browser(self, name=None):
        client = Client()
        if name:
            client.force_login(self.people[name])
        return client

    def form(self, client, address, data, counts, shown_at=None, of="", **more):
        """Return the form with the token that its page shows; `of`: a text in the form's own part of the page."""
        html = client.get(shown_at or address).content.decode()
        forms = [one for one in re.findall(r"<form.*?</form>", html, re.DOTALL) if of in one]
        assert forms, "the page shows it"
        token = re.search(r'name="(once|press)" value="([^"]+)"', forms[0])
        filled = {**data, token[1]: token[2]} if token else data
        return Form(address, filled, counts, client.cookies, more)

    def turn(self):
        now = SYSTEM.now()
        queue.join(self.robot, self.people["ada"], now)
        queue.tick(now)
        turn = queue.accept(self.robot, self.people["ada"], now)
        queue.end_turn(turn, GrantEnd.HOLDER, "ended by the operator", now)
        return turn

    def questions(self):
        return [SurveyQuestion.objects.create(prompt=prompt, kind="text") for prompt in ("What else?", "And?")]


GO = {"kind": "go", "arg-x": "1.0", "name": "", "mail": ""}


def job_of_a_person(world):
    return world.form(world.browser("ada"), "/robots/mercury/jobs/", GO | {"mail": "yes"}, {Job: 1}, of='value="go"')


def job_of_a_guest(world):
    return world.form(world.browser(), "/robots/mercury/jobs/", GO, {Job: 1}, of='value="go"')


def job_of_a_script(world):
    data = {"kind": "go", "arg-x": "1.0", "press": "x" * 36}
    return Form("/robots/mercury/jobs/", data, {Job: 1}, more={"headers": {"accept": "application/json"}})


def survey_of_a_job(world):
    first, second = world.questions()
    guest = world.browser()
    guest.post("/robots/mercury/jobs/", GO)
    Job.objects.update(state="done", ended_at=SYSTEM.now())
    data = {"do": "survey", f"s{first.pk}": "Yes", f"s{second.pk}": "No"}
    return world.form(
        guest, Job.objects.get().get_absolute_url(), data, {SurveyResponse: 1, SurveyAnswer: 2}, of="survey"
    )


def entry(world):
    turn = world.turn()
    still = Frame.objects.create(robot=world.robot, grant=turn.grant, taken_at=SYSTEM.now(), file="frames/a.jpg")
    data = {"text": " A watch.\r\nIt ticks. ", "frame": str(still.pk)}
    return world.form(world.browser("ada"), turn.get_absolute_url(), data, {Entry: 1}, of='name="text"')


def entry_with_answers(world):
    first, second = world.questions()
    data = {"text": "A watch.", f"s{first.pk}": "Yes", f"s{second.pk}": " "}
    counts = {Entry: 1, SurveyResponse: 1, SurveyAnswer: 1}
    return world.form(world.browser("ada"), world.turn().get_absolute_url(), data, counts, of='name="text"')


def answers_of_a_turn(world):
    first, second = world.questions()
    data = {"text": "", f"s{first.pk}": "Yes", f"s{second.pk}": "No"}
    counts = {Entry: 0, SurveyResponse: 1, SurveyAnswer: 2}
    return world.form(world.browser("ada"), world.turn().get_absolute_url(), data, counts, of='name="text"')


def program(world, shared=False):
    body = json.dumps({"name": "Wave", "text": "g 0", "shared": shared})
    more = {"content_type": "application/json"}
    return Form("/robots/mercury/programs/", body, {Program: 1}, world.browser("ada").cookies, more)


def shared_program(world):
    return program(world, shared=True)


def test_of_clearance(world, wrong):
    load_bank(world.robot)
    accounts.mark_read(world.people["eve"], world.robot, SYSTEM.now())
    client = world.browser("eve")
    client.get("/robots/mercury/clearance/")
    attempt = Attempt.objects.get()
    right = {q.id: Choice.objects.get(question=q.id, correct=True).pk for q in accounts.questions(attempt)}
    first = accounts.questions(attempt)[0]
    if wrong:
        right[first.id] = next(pk for pk, _ in first.choices if pk != right[first.id])
    data = {"attempt": attempt.pk} | {f"q{question}": choice for question, choice in right.items()}
    counts = {Attempt: 1, Clearance: Clearance.objects.count() + (not wrong)}
    return world.form(client, "/robots/mercury/clearance/", data, counts, of="attempt")


test_of_clearance.__test__ = False


def failed_test(world):
    return test_of_clearance(world, wrong=True)


def passed_test(world):
    return test_of_clearance(world, wrong=False)


def orientation_read(world):
    client = world.browser("eve")
    return world.form(client, "/robots/mercury/orientation/", {}, {OrientationRead: 1}, of='method="post"')


def place(world):
    data = {"do": "join", "robot": "mercury", "own": "", "next": "/"}
    return Form("/me/places/", data, {Ticket: 1}, world.browser("ada").cookies)


def accepted_offer(world):
    queue.join(world.robot, world.people["ada"], SYSTEM.now())
    queue.tick(SYSTEM.now())
    data = {"do": "accept", "robot": "mercury", "own": "", "next": "/"}
    return Form("/me/places/", data, {Turn: 1}, world.browser("ada").cookies)


def place_in_the_classic_console(world):
    client = world.browser("ada")
    address = client.get("/classic/mercury/")["Location"]
    return Form(address, {"do": "join"}, {Ticket: 1}, client.cookies)


def recording(world):
    grant = world.turn().grant
    made = keeping.begin(grant, "here", SYSTEM.now() - timedelta(days=1))
    path = keeping.path_of(made)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"recorded")
    keeping.finish(made, "ready", "", SYSTEM.now() - timedelta(days=1))
    made.refresh_from_db()
    return made


def movie(world):
    return Form(f"/recordings/{recording(world).key}/movie/", {"kind": "mp4"}, {Movie: 1})


def time_lapse(world):
    day = recording(world).began_at.date().isoformat()
    return Form("/robots/mercury/time-lapse/", {"kind": "webm", "day": day}, {Movie: 1})


def account(world):
    data = {"username": "newone", "email": "new@example.org", "password1": SECRET, "password2": SECRET}
    counts = {User: User.objects.count() + 1, EmailAddress: 1}
    return world.form(Client(), "/accounts/signup/", data, counts, of="password1")


def address(world):
    EmailAddress.objects.create(user=world.people["ada"], email="ada@example.org", verified=True, primary=True)
    client = Client()
    client.post("/accounts/login/", {"login": "ada", "password": SECRET})
    data = {"email": "second@example.org", "action_add": ""}
    return world.form(client, "/accounts/email/", data, {EmailAddress: 2}, of="action_add")


def procedure_of_staff(world):
    kind = "soft_reset"
    pk = world.robot.pk
    of, shown_at = f'value="{kind}"', f"/admin/robots/robot/{pk}/change/"
    counts = {Command: 1, Grant: 1}
    return world.form(
        world.browser("kim"), f"/admin/robots/robot/{pk}/do/procedure/", {"kind": kind}, counts, shown_at, of
    )


OF_JOBS = (job_of_a_person, job_of_a_guest, job_of_a_script, survey_of_a_job)
OTHERS = (
    entry, entry_with_answers, answers_of_a_turn, program, shared_program, failed_test, passed_test, orientation_read,
    place, accepted_offer, place_in_the_classic_console, movie, time_lapse, account, address, procedure_of_staff,
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
    form.data["password2"] = "another horse 42"
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
    "landing", "story", "status", "me", "robot", "model", "statistics", "statistics-json", "composite", "camera",
    "snapshot", "shot", "recordings", "recording", "recording-file", "recording-index", "recording-part", "classic",
    "classic-picture", "log", "survey-results", "survey-csv", "media", "favicon.ico", "livez", "readyz",
    "recordings/<str:key>/movie.mp4", "recordings/<str:key>/movie.webm",
    "robots/<slug:slug>/time-lapse/<str:day>.mp4", "robots/<slug:slug>/time-lapse/<str:day>.webm",
    # a code for one stream of an operator, which lasts for half a minute
    "stream-code",
    # of accounts: what is there is changed, or a mail is sent, of which there is a limit
    "account_login", "account_logout", "account_inactive", "account_reauthenticate", "account_change_password",
    "account_set_password", "account_confirm_email", "account_email_verification_sent", "account_reset_password",
    "account_reset_password_done", "account_reset_password_from_key", "account_reset_password_from_key_done",
    "account_confirm_login_code",
}  # fmt: skip
MAKES = {
    "places": (place, accepted_offer), "programs": (program, shared_program), "orientation": (orientation_read,),
    "clearance": (failed_test, passed_test), "jobs": (job_of_a_person, job_of_a_guest, job_of_a_script),
    "job": (survey_of_a_job,), "ask-lapse": (time_lapse,), "ask-movie": (movie,),
    "classic-page": (place_in_the_classic_console,), "turn": (entry, entry_with_answers, answers_of_a_turn),
    "account_signup": (account,), "account_email": (address,), "admin": (procedure_of_staff,),
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
    """Whoever adds an address says here whether a form that is sent to it makes something."""
    assert set(names(get_resolver().url_patterns)) == MAKES_NOTHING | MAKES.keys()
    assert {one for made in MAKES.values() for one in made} == {*OF_JOBS, *OTHERS}


def test_what_stops_or_bars_a_robot_is_carried_out_at_each_press(robot, people, client):
    """Pages to which somebody goes back send again what their form says."""
    client.force_login(people["kim"])
    html = client.get(f"/admin/robots/robot/{robot.pk}/change/").content.decode()
    forms = {re.search(r"/do/(\w+)/", one)[1]: one for one in re.findall(r"<form[^>]*/do/.*?</form>", html, re.DOTALL)}
    assert {verb for verb, form in forms.items() if 'name="once"' in form} == {"test", "procedure"}
    assert {"stop", "disable", "lock_out"} <= forms.keys()
