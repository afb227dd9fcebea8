"""Orientation, test, pause, clearance; the key never leaves the server."""

import pytest

from accounts import services
from accounts.models import Attempt, Choice, Clearance
from portal.seeding import seed_clearance

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def bank(robot):
    seed_clearance(robot)
    return robot


def right(attempt):
    return {q.id: Choice.objects.get(question=q.id, correct=True).pk for q in services.questions(attempt)}


def begin(user, robot, clock):
    services.mark_read(user, robot, clock.now())
    return services.begin(user, robot, clock.now())


def test_the_orientation_comes_first(bank, people, clock):
    with pytest.raises(services.NotNow, match="orientation"):
        services.begin(people["eve"], bank, clock.now())


def test_all_right_clears(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    assert len(services.questions(attempt)) == 5
    assert services.grade(attempt, right(attempt), clock.now()) == []
    assert services.cleared(people["eve"], bank)


def test_a_wrong_answer_is_explained_and_costs_a_pause(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    answers = right(attempt)
    first = services.questions(attempt)[0]
    answers[first.id] = next(pk for pk, _ in first.choices if pk != answers[first.id])
    feedback = services.grade(attempt, answers, clock.now())
    assert [f.question for f in feedback] == [first.text]
    assert feedback[0].explanation
    assert not services.cleared(people["eve"], bank)
    with pytest.raises(services.NotNow, match="try again"):
        services.begin(people["eve"], bank, clock.go(30))
    assert services.begin(people["eve"], bank, clock.go(31)).pk != attempt.pk


def test_an_attempt_is_graded_once(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    answers = right(attempt)
    services.grade(attempt, dict.fromkeys(answers, 0), clock.now())
    with pytest.raises(services.NotNow, match="already"):
        services.grade(attempt, answers, clock.now())
    assert not Clearance.objects.filter(user=people["eve"]).exists()


def test_a_question_left_out_is_named_and_nothing_is_lost(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    answers = right(attempt)
    answers.popitem()
    with pytest.raises(services.NotNow, match="every question"):
        services.grade(attempt, answers, clock.now())
    attempt.refresh_from_db()
    assert attempt.finished_at is None


def test_reloading_draws_no_new_questions(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    assert services.begin(people["eve"], bank, clock.go(5)).pk == attempt.pk


def test_revoked_is_not_cleared(robot, people, clock):
    Clearance.objects.filter(user=people["ada"]).update(revoked_at=clock.now())
    assert not services.cleared(people["ada"], robot)


def test_through_the_pages(bank, people, client, settings):
    client.force_login(people["eve"])
    page = client.get("/robots/mercury/clearance/", follow=True)
    assert page.redirect_chain[-1][0].endswith("/orientation/")
    client.post("/robots/mercury/orientation/")
    page = client.get("/robots/mercury/clearance/")
    html = page.content.decode()
    attempt = Attempt.objects.get()
    for question in services.questions(attempt):
        assert question.text in html.replace("&#x27;", "'").replace("&quot;", '"')
    assert "correct" not in html.replace("correctly", "")
    data = {"attempt": attempt.pk} | {f"q{q}": c for q, c in right(attempt).items()}
    incomplete = {k: v for k, v in list(data.items())[:-1]}
    answer = client.post("/robots/mercury/clearance/", incomplete)
    assert answer.status_code == 409
    assert b"checked" in answer.content, "the answers given are kept"
    assert client.post("/robots/mercury/clearance/", data).status_code == 302
    assert services.cleared(people["eve"], bank)


def test_somebody_elses_attempt_does_not_exist(bank, people, client, clock):
    attempt = begin(people["eve"], bank, clock)
    client.force_login(people["mod"])
    services.mark_read(people["mod"], bank, clock.now())
    answer = client.post("/robots/mercury/clearance/", {"attempt": attempt.pk} | {f"q{q}": c for q, c in right(attempt).items()})  # fmt: skip
    assert answer.status_code == 404
    assert not services.cleared(people["mod"], bank)
