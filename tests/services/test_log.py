"""The operator's log and the survey."""

from datetime import timedelta

import pytest

from operatorlog import services
from operatorlog.models import Entry, SurveyAnswer, SurveyQuestion, Visibility
from queueing import services as queue
from robots.kit.clock import SYSTEM
from robots.models import Frame, Lease
from robots.states import GrantEnd
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def turn(robot, people):
    now = SYSTEM.now()
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": now + timedelta(days=99)})
    return drive(robot, people["ada"], now)


@pytest.fixture
def ended(turn):
    queue.end_turn(turn, GrantEnd.STAFF, "ended by the operator", SYSTEM.now())
    turn.refresh_from_db()
    return turn


def frame(robot, grant):
    return Frame.objects.create(robot=robot, grant=grant, taken_at=SYSTEM.now(), file="frames/a.jpg")


def test_only_its_operator_writes_and_only_after_the_turn(turn, people, clock):
    with pytest.raises(services.LogError, match="still running"):
        services.write(turn, people["ada"], "x", None, clock.now())
    queue.end_turn(turn, GrantEnd.STAFF, "over", SYSTEM.now())
    turn.refresh_from_db()
    with pytest.raises(services.LogError, match="Only the operator"):
        services.write(turn, people["bob"], "x", None, clock.now())
    mine = frame(turn.robot, turn.grant)
    entry = services.write(turn, people["ada"], " I found a watch. ", mine.pk, clock.now())
    mine.refresh_from_db()
    assert (entry.text, entry.frame, mine.kept) == ("I found a watch.", mine, True)
    with pytest.raises(services.LogError, match="already"):
        services.write(turn, people["ada"], "again", None, clock.now())


def test_a_picture_of_another_turn_is_refused(ended, people, robot, clock):
    with pytest.raises(services.LogError, match="your own turn"):
        services.write(ended, people["ada"], "x", frame(robot, None).pk, clock.now())


@pytest.mark.parametrize("text", ["", "   ", "x" * 2001])
def test_empty_or_endless_texts_are_refused(ended, people, text, clock):
    with pytest.raises(services.LogError):
        services.write(ended, people["ada"], text, None, clock.now())


def test_fifteen_minutes_for_corrections(ended, people, clock):
    entry = services.write(ended, people["ada"], "first", None, clock.now())
    services.edit(entry, people["ada"], "second", None, clock.go(899))
    with pytest.raises(services.LogError, match="15 minutes"):
        services.edit(entry, people["ada"], "third", None, clock.go(2))
    with pytest.raises(services.LogError, match="author"):
        services.edit(entry, people["bob"], "mine", None, clock.now())


def test_hiding_needs_a_moderator_and_a_reason(ended, people, client, clock):
    entry = services.write(ended, people["ada"], "rude words", None, clock.now())
    with pytest.raises(services.LogError, match="moderators"):
        services.moderate(entry, people["ada"], Visibility.HIDDEN, "x", clock.now())
    with pytest.raises(services.LogError, match="reason"):
        services.moderate(entry, people["mod"], Visibility.HIDDEN, " ", clock.now())
    assert b"rude words" in client.get("/log/").content
    services.moderate(entry, people["mod"], Visibility.HIDDEN, "not kind", clock.now())
    assert b"rude words" not in client.get("/log/").content
    assert b"rude words" not in client.get(ended.get_absolute_url()).content
    client.force_login(people["ada"])
    assert b"not kind" in client.get(ended.get_absolute_url()).content, "the author learns why"


def test_the_page_prompts_and_a_strangers_post_is_refused(ended, people, client):
    assert client.post(ended.get_absolute_url(), {"text": "x"}).status_code == 302
    client.force_login(people["bob"])
    assert client.post(ended.get_absolute_url(), {"text": "x"}).status_code == 403
    assert not Entry.objects.exists()
    client.force_login(people["ada"])
    assert b"What did you find?" in client.get(ended.get_absolute_url()).content
    answer = client.post(ended.get_absolute_url(), {"text": "y" * 2001})
    assert answer.status_code == 422
    assert b"y" * 2001 in answer.content, "nothing that was written is lost"
    assert client.post(ended.get_absolute_url(), {"text": "<script>alert(1)</script>"}).status_code == 302
    html = client.get("/log/").content
    assert b"<script>alert" not in html
    assert b"&lt;script&gt;" in html


def test_the_survey_takes_what_is_on_offer_once(ended, people, clock):
    scale = SurveyQuestion.objects.create(prompt="How?", kind="scale")
    choice = SurveyQuestion.objects.create(prompt="Real?", kind="choice", options="Yes\nNo")
    with pytest.raises(services.LogError, match="one of the answers"):
        services.answer_survey(ended, people["ada"], {choice.pk: "Maybe"}, clock.now())
    services.answer_survey(ended, people["ada"], {scale.pk: "4", choice.pk: "", 999: "x"}, clock.now())
    assert list(SurveyAnswer.objects.values_list("value", flat=True)) == ["4"]
    with pytest.raises(services.LogError, match="already"):
        services.answer_survey(ended, people["ada"], {}, clock.now())


def test_results_are_for_staff_and_csv_runs_nothing(ended, people, client, clock):
    question = SurveyQuestion.objects.create(prompt="What for?", kind="text")
    SurveyQuestion.objects.create(prompt="How?", kind="scale")
    services.answer_survey(ended, people["ada"], {question.pk: "=cmd()"}, clock.now())
    client.force_login(people["ada"])
    assert client.get("/survey/results/").status_code == 403
    client.force_login(people["mod"])
    assert client.get("/survey/results/").status_code == 200
    body = client.get("/survey/results.csv").content.decode("utf-8-sig")
    assert "'=cmd()" in body
