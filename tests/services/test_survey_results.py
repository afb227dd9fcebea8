"""The survey's results and their CSV."""

import codecs
import csv
import io
import re

import pytest
from django.contrib.auth.models import Permission
from django.urls import get_resolver

from operatorlog import services
from operatorlog.models import SurveyAnswer, SurveyQuestion
from operatorlog.results import answers_in_words, cell
from robots.kit.clock import SYSTEM
from tests.services.admin_forms import as_sent, controls_of
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
        body = client.get("/survey/results.csv").content.decode("utf-8-sig")
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


def csv_addresses():
    """Return the addresses of the site that answer with CSV; each is opened by its name without arguments."""
    return [f"/{one.pattern}" for one in get_resolver().url_patterns if "csv" in str(one.pattern)]


@pytest.mark.parametrize("address", csv_addresses())
def test_a_spreadsheet_opens_every_csv_with_its_umlauts(answered, client, address):
    """Excel takes a file without byte order mark for Latin-1."""
    answered("Größe: 漢字")
    answer = client.get(address)
    assert answer.content.startswith(codecs.BOM_UTF8)
    assert answer.content.count(codecs.BOM_UTF8) == 1
    assert "Größe: 漢字" in answer.content.decode("utf-8-sig") or "survey" not in address
    assert answer["Content-Type"] == "text/csv; charset=utf-8"
    assert re.fullmatch(r'attachment; filename="farhand-[a-z]+-\d{4}-\d\d-\d\d\.csv"', answer["Content-Disposition"])


def test_a_question_that_became_another_shows_older_answers_as_they_were(answered, people, client):
    answered("5", "a word")
    first, second = SurveyQuestion.objects.all()
    SurveyAnswer.objects.filter(question=first).update(kind="scale")
    client.force_login(admin := people["mod"])
    for question, kind in ((first, "text"), (second, "scale")):
        admin.user_permissions.add(Permission.objects.get(codename="change_surveyquestion"))
        page = f"/admin/operatorlog/surveyquestion/{question.pk}/change/"
        form = controls_of(client.get(page))
        assert client.post(page, as_sent(form, kind=kind)).status_code == 302
    page = client.get("/survey/results/").content.decode()
    assert "Before, when it was a question of the kind “Scale 1 to 5”" in page
    assert "1 answer, mean 5.0 of 5" in page
    assert "Before, when it was a question of the kind “Text”" in page
    assert "<li>a word</li>" in page
    assert "0 answers<" in page, "nobody has answered on the scale"


def test_an_answer_of_an_older_backup_is_of_the_kind_that_its_question_has(answered, client):
    answered("4", "x")
    SurveyAnswer.objects.update(kind="")
    SurveyQuestion.objects.update(kind="scale")
    page = client.get("/survey/results/").content.decode()
    assert "1 answer, mean 4.0 of 5" in page
    assert '<th scope="row">x</th>' in page


@pytest.mark.parametrize(("count", "words"), [(0, "0 answers"), (1, "1 answer"), (2, "2 answers")])
def test_one_answer_is_no_plural(count, words):
    assert answers_in_words(count) == words


def test_the_page_counts_people(answered, client):
    answered("x")
    assert "1 person has answered" in client.get("/survey/results/").content.decode()


def test_who_may_see_the_results_finds_them(people, client):
    for who, shown in (("mod", True), ("ada", False), ("kim", False)):
        client.force_login(people[who])
        assert ("/survey/results/" in client.get("/log/").content.decode()) == shown, who
        if people[who].is_staff:
            assert ("/survey/results/" in client.get("/admin/").content.decode()) == shown, who
