"""Orientation, test, pause, clearance; the right answers never leave the server."""

import re
import threading
from concurrent.futures import ThreadPoolExecutor
from html import unescape

import pytest
from django.db import connection

from accounts import services, staff
from accounts.models import Attempt, Choice, Clearance, Question
from accounts.services import load_bank
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest
from robots.services.permissions import NotStaff
from tests.waiting import CEILING_S

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def bank(robot):
    load_bank(robot)
    return robot


def right(attempt):
    return {q.id: Choice.objects.get(question=q.id, correct=True).pk for q in services.questions(attempt)}


def begin(user, robot, clock):
    services.mark_read(user, robot, clock.now())
    return services.begin(user, robot, clock.now())


@pytest.mark.asvs("2.3.1")
def test_the_orientation_comes_first(bank, people, clock):
    with pytest.raises(services.NotNow, match="orientation"):
        services.begin(people["eve"], bank, clock.now())


def test_all_right_clears(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    assert len(services.questions(attempt)) == 5
    assert services.grade(attempt, people["eve"], right(attempt), clock.now()) == []
    assert services.cleared(people["eve"], bank)


def wrongly(attempt, number=1):
    """Return answers of which the first ones are wrong."""
    answers = right(attempt)
    for one in services.questions(attempt)[:number]:
        answers[one.id] = next(pk for pk, _ in one.choices if pk != answers[one.id])
    return answers


def fail(user, robot, clock, number=1):
    attempt = begin(user, robot, clock)
    return attempt, services.grade(attempt, user, wrongly(attempt, number), clock.now())


@pytest.mark.parametrize("number", [1, 3, 5])
def test_each_wrong_answer_names_its_paragraph(bank, people, clock, number):
    attempt, hints = fail(people["eve"], bank, clock, number)
    asked = [Question.objects.get(pk=q.id) for q in services.questions(attempt)[:number]]
    named = [(hint.topic, hint.section, hint.paragraph) for hint in hints]
    assert set(named) == {(q.topic, q.section, q.paragraph) for q in asked}
    assert len(named) == len(set(named))
    assert not services.cleared(people["eve"], bank)


def test_the_first_failure_costs_no_pause_and_the_second_does(bank, people, clock):
    attempt, _ = fail(people["eve"], bank, clock)
    again, _ = fail(people["eve"], bank, clock)
    assert not {q.id for q in services.questions(attempt)} & {q.id for q in services.questions(again)}
    with pytest.raises(services.NotNow, match="try again"):
        services.begin(people["eve"], bank, clock.go(29))
    assert services.begin(people["eve"], bank, clock.go(1))


def test_the_pause_grows_and_is_forgotten_after_a_pass(bank, people, clock):
    for pause in (0, 30, 60, 120, 240):
        fail(people["eve"], bank, clock)
        assert services.pause_left(people["eve"], bank, clock.now()) == pause
        clock.go(pause)
    attempt = begin(people["eve"], bank, clock)
    assert services.grade(attempt, people["eve"], right(attempt), clock.now()) == []
    assert services.pause_left(people["eve"], bank, clock.go(1)) == 0


def test_the_pause_is_asked_when_grading_too(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    for _ in range(2):
        Attempt.objects.create(
            user=people["eve"], robot=bank, drawn=[], started_at=clock.now(), finished_at=clock.now(), passed=False
        )
    with pytest.raises(services.NotNow, match="try again"):
        services.grade(attempt, people["eve"], right(attempt), clock.go(5))
    assert not services.cleared(people["eve"], bank)


def test_nobody_sends_somebody_elses_test(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    with pytest.raises(services.NotNow, match="belongs to another person"):
        services.grade(attempt, people["mod"], right(attempt), clock.now())


def test_questions_that_went_meanwhile_make_no_easier_test(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    Question.objects.all().delete()
    with pytest.raises(services.NotNow, match="changed meanwhile"):
        services.grade(attempt, people["eve"], {}, clock.now())
    assert not services.cleared(people["eve"], bank)


@pytest.mark.asvs("2.3.1", "2.4.1")
@pytest.mark.django_db(transaction=True)
def test_many_requests_at_once_open_one_attempt(bank, people, clock):
    services.mark_read(people["eve"], bank, clock.now())
    together = threading.Barrier(12)

    def ask(_):
        together.wait(CEILING_S)
        try:
            return services.begin(people["eve"], bank, clock.now()).pk
        finally:
            connection.close()

    with ThreadPoolExecutor(12) as pool:
        found = set(pool.map(ask, range(12)))
    assert len(found) == 1
    assert Attempt.objects.count() == 1


def test_an_attempt_is_graded_once(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    answers = right(attempt)
    services.grade(attempt, people["eve"], dict.fromkeys(answers, 0), clock.now())
    with pytest.raises(services.NotNow, match="already"):
        services.grade(attempt, people["eve"], answers, clock.go(61))
    assert not Clearance.objects.filter(user=people["eve"]).exists()


def test_a_question_left_out_is_named_and_nothing_is_lost(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    answers = right(attempt)
    answers.popitem()
    with pytest.raises(services.NotNow, match="every question"):
        services.grade(attempt, people["eve"], answers, clock.now())
    attempt.refresh_from_db()
    assert attempt.finished_at is None


def test_reloading_draws_no_new_questions(bank, people, clock):
    attempt = begin(people["eve"], bank, clock)
    assert services.begin(people["eve"], bank, clock.go(5)).pk == attempt.pk


@pytest.mark.asvs("2.3.1")
def test_withdrawn_is_not_earned_again_until_staff_lift_it(bank, people, clock, admin_user):
    ada, held = people["ada"], Clearance.objects.get(user=people["ada"])
    open_one = begin(ada, bank, clock)
    with pytest.raises(NotStaff):
        staff.withdraw(held, people["kim"], "rude", clock.now())
    with pytest.raises(BadRequest, match="note"):
        staff.withdraw(held, admin_user, " ", clock.now())
    assert staff.withdraw(held, admin_user, "Threw sand out.", clock.now())
    assert not staff.withdraw(held, admin_user, "twice", clock.go(1))
    assert not services.cleared(ada, bank)
    for ask in (lambda: services.begin(ada, bank, clock.now()), lambda: services.grade(open_one, ada, right(open_one), clock.now())):  # fmt: skip
        with pytest.raises(services.NotNow, match="Staff withdrew your clearance on 1 January 2026.*Threw sand out"):
            ask()
    assert not services.cleared(ada, bank)
    assert staff.lift(held, admin_user, "Talked to her.", clock.go(60))
    assert not services.cleared(ada, bank), "lifting clears nobody: the test comes first"
    assert services.grade(open_one, ada, right(open_one), clock.go(60)) == []
    assert services.cleared(ada, bank)
    held.refresh_from_db()
    assert staff.withdraw(held, admin_user, "Again.", clock.go(60))
    with pytest.raises(services.NotNow, match="Again"):
        services.begin(ada, bank, clock.now())


def test_a_withdrawal_while_a_test_is_graded_stands(bank, people, clock, admin_user, monkeypatch):
    first = begin(people["eve"], bank, clock)
    services.grade(first, people["eve"], right(first), clock.now())
    held = Clearance.objects.get(user=people["eve"])
    attempt = begin(people["eve"], bank, clock)
    answers, looked = right(attempt), services.questions

    def meanwhile(asked):
        staff.withdraw(held, admin_user, "Threw sand out.", clock.now())
        return looked(asked)

    monkeypatch.setattr(services, "questions", meanwhile)
    with pytest.raises(services.NotNow, match="withdrew your clearance"):
        services.grade(attempt, people["eve"], answers, clock.go(1))
    held.refresh_from_db()
    assert (held.note, services.cleared(people["eve"], bank)) == ("Threw sand out.", False)


def test_staff_withdraw_and_lift_from_the_admin_with_a_note(bank, people, client, admin_user):
    client.force_login(admin_user)
    held = Clearance.objects.get(user=people["ada"])
    data = {"action": "withdraw", "_selected_action": [held.pk]}
    page = client.post("/admin/accounts/clearance/", data, follow=True)
    assert b"Write a note" in page.content
    assert services.cleared(people["ada"], bank)
    client.post("/admin/accounts/clearance/", data | {"note": "Threw sand."})
    assert not services.cleared(people["ada"], bank)
    other = type(client)()
    other.force_login(people["ada"])
    services.mark_read(people["ada"], bank, SYSTEM.now())
    assert b"Threw sand." in other.get("/robots/mercury/clearance/").content
    client.post("/admin/accounts/clearance/", data | {"action": "lift", "note": "Welcome back."})
    assert other.get("/robots/mercury/clearance/").status_code == 200


def test_a_bank_of_before_topics_is_filled_up_once(robot):
    load_bank(robot)
    full = Question.objects.count()
    Question.objects.update(topic="")
    Question.objects.all()[0].delete()
    assert load_bank(robot) == 1
    assert load_bank(robot) == 0
    assert (Question.objects.count(), Question.objects.filter(topic="").count()) == (full, 0)


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


def test_the_page_of_a_first_failure_offers_the_next_try_at_once(bank, people, client):
    services.mark_read(people["eve"], bank, SYSTEM.now())
    client.force_login(people["eve"])
    client.get("/robots/mercury/clearance/")
    attempt = Attempt.objects.get()
    data = {"attempt": attempt.pk} | {f"q{q}": c for q, c in wrongly(attempt, 2).items()}
    html = client.post("/robots/mercury/clearance/", data, follow=True).content.decode()
    assert "try again at once" in html
    assert "data-pause" not in html
    asked = [Question.objects.get(pk=q.id) for q in services.questions(attempt)[:2]]
    assert len(re.findall(r"orientation/#", html)) == len({(q.section, q.paragraph) for q in asked})
    assert client.get("/robots/mercury/clearance/").status_code == 200


def test_the_result_of_a_failed_test_is_a_page_of_its_own_to_which_one_can_go_back(bank, people, client, clock):
    attempt = begin(people["eve"], bank, clock)
    client.force_login(people["eve"])
    data = {"attempt": attempt.pk} | {f"q{q}": c for q, c in wrongly(attempt).items()}
    answer = client.post("/robots/mercury/clearance/", data)
    assert answer.status_code == 302
    for _ in range(2):
        assert client.get(answer["Location"]).context["hints"]
    services.mark_read(people["mod"], bank, clock.now())
    client.force_login(people["mod"])
    assert "hints" not in client.get(answer["Location"]).context, "another person's"


@pytest.mark.parametrize("wrong", ["", "x", "-1", "9" * 30])
def test_an_address_that_names_no_failed_attempt_shows_the_questions(bank, people, client, clock, wrong):
    attempt = begin(people["eve"], bank, clock)
    client.force_login(people["eve"])
    for pk in (wrong, attempt.pk):
        assert client.get(f"/robots/mercury/clearance/?attempt={pk}").context["questions"]


def test_somebody_elses_attempt_does_not_exist(bank, people, client, clock):
    attempt = begin(people["eve"], bank, clock)
    client.force_login(people["mod"])
    services.mark_read(people["mod"], bank, clock.now())
    answer = client.post("/robots/mercury/clearance/", {"attempt": attempt.pk} | {f"q{q}": c for q, c in right(attempt).items()})  # fmt: skip
    assert answer.status_code == 404
    assert not services.cleared(people["mod"], bank)


def test_a_failed_test_shows_paragraphs_and_neither_answers_nor_a_score(bank, people, client, clock):
    fail(people["eve"], bank, SYSTEM)
    client.force_login(people["eve"])
    client.get("/robots/mercury/clearance/")
    attempt = Attempt.objects.get(finished_at=None)
    data = {"attempt": attempt.pk} | {f"q{q}": c for q, c in wrongly(attempt).items()}
    html = unescape(client.post("/robots/mercury/clearance/", data, follow=True).content.decode())
    first = Question.objects.get(pk=services.questions(attempt)[0].id)
    assert f"{first.section}, paragraph {first.paragraph}" in html
    assert first.explanation not in html
    for question in services.questions(attempt):
        assert question.text not in html
        said = [text for _, text in question.choices if len(text) > 10 and text != first.topic]  # the topic is told
        assert not any(text in html for text in said)
    link = re.search(r'href="(/robots/mercury/orientation/)#([^"]+)"', html)
    assert f'id="{link[2]}"' in client.get(link[1]).content.decode()
    again = client.get("/robots/mercury/clearance/")
    assert again.status_code == 409
    assert b"you can try again in" in again.content
    assert "You can try again in 30 seconds" in html
    reloaded = client.post("/robots/mercury/clearance/", data, follow=True)
    assert (reloaded.status_code, reloaded.context["hints"][0]["section"]) == (200, first.section), "the same answer"
    others = data | {f"q{q.id}": q.choices[0][0] for q in services.questions(attempt)}
    others[f"q{first.pk}"] = next(c for c, _ in services.questions(attempt)[0].choices if c != data[f"q{first.pk}"])
    assert client.post("/robots/mercury/clearance/", others).status_code == 409
