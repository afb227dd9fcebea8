"""The rules of the clearance test, and the chances of a person who tries one answer after another."""

import random
import tomllib
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from accounts import quiz
from accounts.orientation import render
from tests.environment import ROOT

FOLDERS = [ROOT / "robots/kit/drivers" / name for name in ("mercury", "pa10", "puma", "so101", "irat")]
FOLDERS.append(ROOT / "tests" / "packages" / "turntable" / "turntable_robot")
DRAWN, CHOICES = 5, 4
FIRST_S, MOST_S = 60, 86_400


@given(st.sets(st.integers(0, 60), min_size=1), st.sets(st.integers(0, 60)), st.integers(1, 8), st.integers())
def test_other_questions_come_as_far_as_the_bank_allows(bank, seen, count, seed):
    drawn = quiz.draw(sorted(bank), seen, count, random.Random(seed))
    assert len(drawn) == len(set(drawn)) == min(count, len(bank))
    assert set(drawn) <= bank
    fresh = bank - seen
    assert len(set(drawn) & fresh) == min(len(fresh), len(drawn)), "one seen before only where no other is left"


def test_the_pause_doubles_up_to_a_day():
    assert [quiz.pause_s(n, FIRST_S, MOST_S) for n in (0, 1, 2, 3, 11, 12, 10**6)] == [
        0, 60, 120, 240, 61_440, 86_400, 86_400,
    ]  # fmt: skip


def attack(rng, bank, topics, tries):
    """Return at which try an attacker passes who never repeats an answer that is known to be wrong; None if never."""
    left = {q: set(range(CHOICES)) for q in range(bank)}
    seen: list[int] = []
    for attempt in range(1, tries + 1):
        seen = quiz.draw(range(bank), seen, DRAWN, rng)
        given_ = {q: rng.choice(sorted(left[q])) for q in seen}
        wrong = [q for q in seen if given_[q] != 0]
        if not wrong:
            return attempt
        topic = topics[quiz.question_of_hint(wrong, rng)]
        suspects = [q for q in seen if topics[q] == topic and len(left[q]) > 1]
        if len(suspects) == 1:  # else the attacker cannot tell which of them it was
            left[suspects[0]].discard(given_[suspects[0]])
    return None


def chance(bank, topics, tries, runs=2000):
    rng = random.Random(1994)
    return sum(attack(rng, bank, topics, tries) is not None for _ in range(runs)) / runs


@pytest.mark.asvs("2.3.1", "2.4.1")
@pytest.mark.parametrize("folder", FOLDERS[:4], ids=lambda f: f.name)
def test_an_attacker_who_eliminates_answers_seldom_gets_through(folder):
    """Ten tries cost eight and a half hours of pauses, twenty more than a week; reading takes three minutes."""
    questions = bank_of(folder)
    topics = [q["topic"] for q in questions]
    assert sum(quiz.pause_s(n, FIRST_S, MOST_S) for n in range(1, 10)) > 8 * 3600
    assert chance(len(topics), topics, 10) < 0.03
    assert chance(len(topics), topics, 20, 800) < 0.15


def test_naming_every_wrong_answer_would_let_the_attacker_through():
    """The judge can fail: with all wrong answers named, eight tries are enough for a third of them."""
    rng, through = random.Random(1994), 0
    for _ in range(500):
        left, seen = {q: set(range(CHOICES)) for q in range(15)}, []
        for _ in range(8):
            seen = quiz.draw(range(15), seen, DRAWN, rng)
            given_ = {q: rng.choice(sorted(left[q])) for q in seen}
            if not any(given_.values()):
                through += 1
                break
            for q, answer in given_.items():
                left[q] = left[q] - {answer} if answer else {0}
    assert through / 500 > 0.33


def bank_of(folder):
    return tomllib.loads((folder / "clearance.toml").read_text())["question"]


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda f: f.name)
def test_each_bank_is_three_times_what_is_drawn_and_points_at_paragraphs_that_exist(folder):
    questions, page = bank_of(folder), render((folder / "orientation.md").read_text())
    assert len(questions) >= 3 * DRAWN
    assert len({q["text"] for q in questions}) == len(questions)
    for question in questions:
        assert (question["section"], question["paragraph"]) in page.anchors, question["text"]
        assert question["topic"]
        assert len(question["choices"]) == len(set(question["choices"])) == CHOICES, question["text"]
        longest = max(question["choices"][1:], key=len)
        assert len(question["choices"][0]) <= 1.6 * len(longest) + 4, (
            f"the right answer shows by its length: {question}"
        )
    pointed = {(q["topic"], q["section"], q["paragraph"]) for q in questions}
    assert Counter(topic for topic, _, _ in pointed).most_common(1)[0][1] == 1, "one topic, one paragraph"


def test_list_items_count_as_paragraphs_and_html_is_escaped():
    page = render("# A\n\none\n\n## What you do\n\nfirst\n\n- second\n\n  still second\n- <b>third</b>\n")
    assert page.anchors == {
        ("A", 1): "a-1", ("What you do", 1): "what-you-do-1", ("What you do", 2): "what-you-do-2",
        ("What you do", 3): "what-you-do-3",
    }  # fmt: skip
    assert '<li id="what-you-do-3">' in page.html
    assert "<b>" not in page.html


def test_a_control_has_one_number_wherever_the_text_names_it():
    page = render(
        "Press [Up](control:up), then [Down](control:down), then [Up](control:up). [Read](https://example.org)."
    )
    assert page.controls == ("up", "down")
    assert page.html.count('<b class="control" data-number="1">Up</b>') == 2
    assert '<b class="control" data-number="2">Down</b>' in page.html
    assert '<a href="https://example.org">Read</a>' in page.html
