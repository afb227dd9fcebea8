"""The page of a robot's statistics and its JSON, over rows of jobs and commands; and the survey after a job."""

from datetime import timedelta
from math import nan

import pytest
from django.db import connection
from django.test import Client

from operatorlog.models import SurveyAnswer, SurveyQuestion, SurveyResponse
from portal.web.statistics import reading
from queueing import services as queue
from queueing.models import Job
from queueing.services import Asker, ask
from robots.kit.contract.session import Outcome, RobotState
from robots.models import Command, Lease
from robots.states import CommandState
from tests.services.owner import Arm, made_owner
from tests.services.test_jobs import settle

pytestmark = [pytest.mark.service, pytest.mark.django_db]
PAGE, DATA = "/robots/mercury/statistics/", "/robots/mercury/statistics.json"


@pytest.fixture(autouse=True)
def at_that_time(clock, monkeypatch):
    """Views ask the tests' clock."""
    monkeypatch.setattr("portal.web.statistics.views.SYSTEM", clock)


def trip(robot, clock, person, state=CommandState.COMPLETED, before=0.5, after=0.4, driven=(0.0, 1.0), **result):
    """Let somebody's job run to its end."""
    job = ask(robot, Asker(user=person), "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    told = {"began": {"battery": before, "driven": driven[0]}, "ended": {"battery": after, "driven": driven[1]}}
    Command.objects.filter(ended_at=None).update(accepted_at=clock.now())
    settle(clock, state, "", 60, channels=told, **result)
    clock.go(1)
    return job


def rows(client, **query):
    return {row["label"]: row["value"] for row in client.get(DATA, query).json()["rows"]}


def test_the_rows_are_counted_from_jobs_commands_and_channels(shuttle, people, clock, client):
    ada, bob = people["ada"], people["bob"]
    trip(shuttle, clock, ada, driven=(10.0, 12.5))
    trip(shuttle, clock, bob, driven=(12.5, 13.0))
    trip(shuttle, clock, ada, CommandState.FAILED, code="gave_up", driven=(13.0, 13.25), before=0.9)
    trip(shuttle, clock, ada, CommandState.REJECTED, code="rail", driven=(13.25, 13.25))
    trip(shuttle, clock, ada, CommandState.REJECTED, code="bad_request", driven=(0.0, 0.5))
    ask(shuttle, Asker(user=ada), "go", {"x": 1.0}, clock.now())
    clock.go(1)
    assert rows(client) == {
        "Trips asked for": 6, "People and guests who asked": 2, "Trips attempted": 3, "Trips arrived": 2,
        "Arrived, of those attempted": pytest.approx(200 / 3), "Given up by the robot": 1,
        "Ended by faults of the robot": 0, "Cut off; how they ended is not known": 0,
        "Dropped, because the rail was taken away": 1, "Refused by the robot": 1,
        "Cancelled or stopped by people": 0, "Still waiting or under way": 1,
        "Driven": pytest.approx(3.75), "Recharges": 0, "Recharges that failed": 0,
        "Time on the rail": pytest.approx(100 * 300 / 86400),
        "Time online": None, "Most visitors at once": None,
        "Sent to visitors, live": None, "Sent to visitors, live, on average": None,
    }  # fmt: skip
    told = client.get(DATA).json()
    assert sum(hour["asked"] for hour in told["hours"]) == 6
    assert [(b["attempted"], b["done"]) for b in told["success"]["bins"]] == [(3, 2)]
    assert told["complete"] is True


def test_a_day_has_its_own_rows_and_two_days_add_up(shuttle, people, clock, client):
    first = clock.now()
    trip(shuttle, clock, people["ada"], driven=(0.0, 2.0))
    clock.go(86_400)
    trip(shuttle, clock, people["ada"], driven=(2.5, 3.0))
    before, after = rows(client, **{"from": first.isoformat()}), rows(client)
    assert (before["Trips asked for"], after["Trips asked for"]) == (1, 1)
    assert (before["Driven"], after["Driven"]) == (2.0, 1.0), "what was driven between two motions is in the next day"
    again = client.get(DATA, {"from": client.get(DATA, {"from": first.isoformat()}).json()["from"]}).json()
    assert again["rows"][0]["value"] == 1, "what it tells as its beginning can be asked for"
    nothing = rows(client, **{"from": (first - timedelta(days=3)).isoformat()})
    assert (nothing["Trips asked for"], nothing["Driven"], nothing["Arrived, of those attempted"]) == (0, None, None)


def test_the_page_shows_table_plots_and_words_for_everybody(shuttle, people, clock):
    trip(shuttle, clock, people["ada"])
    answer = Client().get(PAGE)
    page = answer.content.decode()
    assert answer.status_code == 200
    for words in ("Trips asked for", "Trips an hour as a table", "Success against battery", "<polyline", "100.0 %"):
        assert words in page, words
    assert "style=" not in page
    assert f'href="{PAGE}"' in Client().get("/robots/mercury/jobs/").content.decode()


@pytest.mark.parametrize("text", ["soon", "2026-02-30", "1999-12-31", "2999-01-01", "²", "9999-12-31T23:59-23:00"])
def test_a_bad_date_is_a_sentence_with_400(shuttle, client, text):
    page, data = client.get(PAGE, {"from": text}), client.get(DATA, {"from": text})
    assert (page.status_code, data.status_code) == (400, 400)
    assert data.json()["error"].endswith(".")
    assert 'role="alert"' in page.content.decode()


def test_a_request_reads_so_many_rows_and_no_more(
    shuttle, people, clock, client, monkeypatch, django_assert_max_num_queries
):
    monkeypatch.setattr(reading, "MOST_JOBS", 2)
    monkeypatch.setattr(reading, "MOST_MOTIONS", 2)
    for _ in range(4):
        trip(shuttle, clock, people["ada"])
    with django_assert_max_num_queries(12):
        told = client.get(DATA).json()
    assert told["complete"] is False
    assert told["rows"][0]["value"] == 2
    assert "More happened than one page counts" in client.get(PAGE).content.decode()


@pytest.mark.timed
@pytest.mark.usefixtures("one_count")
def test_one_address_asks_so_often_a_minute(shuttle, client, settings):
    settings.RATE_LIMITS = {"statistics": "2/m/ip"}
    assert [client.get(address).status_code for address in (DATA, PAGE, DATA, PAGE)] == [200, 200, 429, 429]
    assert client.get(DATA, REMOTE_ADDR="192.0.2.9").status_code == 200


@pytest.mark.timed
@pytest.mark.usefixtures("one_count")
def test_a_shared_cache_keeps_answers_and_no_refusals(shuttle, client, settings):
    settings.RATE_LIMITS = {"statistics": "2/m/ip"}
    answers = [client.get(DATA, {"from": day}) for day in ("", "soon", "")]
    assert [answer.status_code for answer in answers] == [200, 400, 429]
    assert [answer["Cache-Control"] for answer in answers] == ["public, max-age=60", "no-store", "no-store"]


def test_the_indexes_are_used(shuttle, clock):
    ended = Command.objects.filter(robot=shuttle, lane="motion", ended_at__gte=clock.now()).order_by("ended_at", "id")
    asked = Job.objects.filter(robot=shuttle, asked_at__gte=clock.now()).order_by("asked_at", "id")
    for found, index in ((ended, "commands_by_end"), (asked, "jobs_by_time")):
        with connection.cursor() as cursor:
            assert index in connection.introspection.get_constraints(cursor, found.model._meta.db_table)
        if connection.vendor == "sqlite":  # PostgreSQL reads a table as small as this one whole
            assert index in found.explain()


class Cart(Arm):
    """A cart that empties its battery on the way, and at last tells nonsense."""

    battery = 0.8

    def latest(self):
        odd = {"driven": nan, "more": 1.0} if self.battery < 0.5 else {"driven": 3.0}
        return RobotState(0.0, (0.0,), (0.0,), False, True, values={"battery": self.battery, **odd})

    def execute(self, kind, args, permit, on_stage):
        permit()
        on_stage("sent")
        on_stage("acknowledged")
        self.battery = 0.4
        return Outcome(args, self.latest())


@pytest.mark.django_db(transaction=True)
def test_the_owner_stores_the_declared_channels_with_a_motion(shuttle, people):
    Lease.objects.all().delete()
    owner = made_owner(shuttle, people)
    owner.owned.driver = Cart()
    grant = shuttle.grants.get()
    command = Command.objects.create(
        robot=shuttle, grant=grant, client_seq=1, kind="roam", epoch=owner.lease.epoch, created_at=owner.owned.now(),
        deadline=owner.owned.now() + timedelta(seconds=5),
    )  # fmt: skip
    owner.motion.run_one(command)
    command.refresh_from_db()
    assert command.state == "completed"
    assert command.result["channels"] == {"began": {"battery": 0.8, "driven": 3.0}, "ended": {"battery": 0.4}}


@pytest.fixture
def question(db):
    return SurveyQuestion.objects.create(
        prompt="How did the video look?", kind="choice", options="Smooth\nChoppy", after="job"
    )


def ended_job(client, clock):
    """Let a job of this browser end; return its address."""
    address = client.post("/robots/mercury/jobs/", {"kind": "go", "arg-x": "1.0"})["Location"]
    queue.tick(clock.now())
    settle(clock)
    return address


def test_a_guest_answers_once_a_job_and_the_answers_name_nobody(shuttle, clock, question):
    guest, other, field = Client(), Client(), f"s{question.pk}"
    address = ended_job(guest, clock)
    sent = {"do": "survey", field: "Smooth"}
    assert b"How did the video look?" in guest.get(address).content
    assert b"How did the video look?" not in other.get(address).content
    assert other.post(address, sent).status_code == 403
    assert guest.post(address, {"do": "survey", field: "Blurred"}).status_code == 422
    assert guest.post(address, {"do": "survey"}).status_code == 422
    assert guest.post(address, sent).status_code == 302
    assert guest.post(address, sent).status_code == 403, "once a job"
    assert b"How did the video look?" not in guest.get(address).content
    response = SurveyResponse.objects.get()
    assert (response.turn, response.robot, SurveyAnswer.objects.get().value) == (None, shuttle, "Smooth")
    assert (response.at.hour, response.at.minute, response.at.second) == (0, 0, 0)


def test_a_job_that_waits_has_no_survey_and_a_turn_has_other_questions(shuttle, clock, question):
    guest = Client()
    address = guest.post("/robots/mercury/jobs/", {"kind": "go", "arg-x": "1.0"})["Location"]
    assert b"How did the video look?" not in guest.get(address).content
    assert guest.post(address, {"do": "survey", f"s{question.pk}": "Smooth"}).status_code == 403
    assert Job.objects.get().state == "waiting", "an answer cancels nothing"
    SurveyQuestion.objects.update(after="turn")
    queue.tick(clock.now())
    settle(clock)
    assert b"How did the video look?" not in guest.get(address).content


@pytest.mark.timed
@pytest.mark.usefixtures("one_count")
def test_many_answers_of_one_address_are_refused_for_a_while(shuttle, clock, question, settings):
    settings.RATE_LIMITS = {"survey": "2/m/ip"}
    guest = Client()
    address = ended_job(guest, clock)
    found = [guest.post(address, {"do": "survey"}).status_code for _ in range(3)]
    assert found == [422, 422, 429]


def test_answers_after_a_job_are_in_the_csv(shuttle, people, clock, question):
    guest, staff = Client(), Client()
    guest.post(ended_job(guest, clock), {"do": "survey", f"s{question.pk}": "Choppy"})
    staff.force_login(people["mod"])
    assert staff.get("/survey/results.csv").content.decode().splitlines()[1].startswith(",mercury,")
    assert staff.get("/survey/results/").status_code == 200
