"""The survey's results and their CSV."""

import csv
import io

import pytest

from operatorlog import services
from operatorlog.models import SurveyQuestion
from operatorlog.results import cell, counted
from robots.clock import SYSTEM
from tests.services.test_log import ended, turn  # noqa: F401

pytestmark = [pytest.mark.service, pytest.mark.django_db]
RUN = ("=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "\n=1", " =1", "＝1", "＋1", "－1", "＠x")


@pytest.fixture
def answered(ended, people, client):  # noqa: F811
    """Answer these texts, one question each; return the rows of the CSV."""

    def make(*texts):
        questions = [SurveyQuestion.objects.create(prompt=f"Q{n}", kind="text") for n in range(len(texts))]
        given = {q.pk: text for q, text in zip(questions, texts, strict=True)}
        services.answer_survey(ended, people["ada"], given, SYSTEM.now())
        client.force_login(people["mod"])
        body = client.get("/survey/results.csv").content.decode()
        return list(csv.reader(io.StringIO(body, newline="")))

    return make


def test_an_empty_answer_is_an_empty_cell(answered):
    rows = answered("", "fine, “really”", "x")
    assert rows[1][3:] == ["", "fine, “really”", "x"]


@pytest.mark.parametrize("text", RUN)
def test_no_cell_can_be_run(text):
    assert cell(text) == f"'{text}"
    assert cell(f"a{text}") == f"a{text}"


def test_every_column_is_guarded(answered, robot):
    SurveyQuestion.objects.create(prompt="=cmd", kind="text")
    type(robot).objects.filter(pk=robot.pk).update(slug="-1")
    rows = answered("=1")
    assert rows[0][:3] == ["turn", "robot", "at"]
    assert "'=cmd" in rows[0]
    assert rows[1][1] == "'-1"
    assert "'=1" in rows[1]


@pytest.mark.parametrize(("count", "words"), [(0, "0 answers"), (1, "1 answer"), (2, "2 answers")])
def test_one_answer_is_no_plural(count, words):
    assert counted(count) == words


def test_the_page_counts_people(answered, client):
    answered("x")
    assert "1 person has answered" in client.get("/survey/results/").content.decode()


def test_who_may_see_the_results_finds_them(people, client):
    for who, shown in (("mod", True), ("ada", False), ("kim", False)):
        client.force_login(people[who])
        assert ("/survey/results/" in client.get("/log/").content.decode()) == shown, who
        if people[who].is_staff:
            assert ("/survey/results/" in client.get("/admin/").content.decode()) == shown, who
