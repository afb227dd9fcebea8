"""Forms that create something, as a browser has them; each is sent twice."""

import json
import re
import threading
from dataclasses import dataclass, field
from datetime import timedelta
from http.cookies import SimpleCookie

from allauth.account.models import EmailAddress
from django.db import connection
from django.test import Client

from accounts import services as accounts
from accounts.models import Attempt, Choice, Clearance, OrientationRead, PushSubscription, User
from accounts.services import load_bank
from operatorlog.models import Entry, SurveyAnswer, SurveyQuestion, SurveyResponse
from queueing import services as queue
from queueing.models import Job, Ticket, Turn
from robots.kit.clock import SYSTEM
from robots.models import Frame, Movie, Program
from robots.recordings import keeping
from robots.states import GrantEnd
from tests.services.push_service import Browser
from tests.services.turns import drive

SECRET = "correct horse 42"
POPUP = re.compile(rb'data-popup-response="([^"]+)')  # by which the admin's small window fills in the form behind it


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
        body = answer.json() if "json" in answer["Content-Type"] else POPUP.findall(answer.content)
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
        turn = drive(self.robot, self.people["ada"], now)
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


def clearance_test(world, wrong):
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


def failed_test(world):
    return clearance_test(world, wrong=True)


def passed_test(world):
    return clearance_test(world, wrong=False)


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


def push_subscription(world):
    browser = Browser("https://push.example.org/send/a")
    data = {"do": "tell", **browser.fields}
    more = {"headers": {"accept": "application/json"}}
    return Form("/me/push/", data, {PushSubscription: 1}, world.browser("ada").cookies, more)


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
    data = {"username": "newone", "email": "new@example.org", "password1": SECRET}
    counts = {User: User.objects.count() + 1, EmailAddress: 1}
    return world.form(Client(), "/accounts/signup/", data, counts, of="password1")


def address(world):
    EmailAddress.objects.create(user=world.people["ada"], email="ada@example.org", verified=True, primary=True)
    client = Client()
    client.post("/accounts/login/", {"login": "ada", "password": SECRET})
    data = {"email": "second@example.org", "action_add": ""}
    return world.form(client, "/accounts/email/", data, {EmailAddress: 2}, of="action_add")
