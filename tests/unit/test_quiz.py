"""The rules of the clearance test, and the chances of a person who tries one answer after another."""

import random
import tomllib
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from accounts import quiz
from accounts.orientation import LATER, render
from tests.environment import ROOT

FOLDERS = [ROOT / "robots/kit/drivers" / name for name in ("mercury", "pa10", "puma", "so101", "irat", "srv1")]
FOLDERS.append(ROOT / "tests" / "packages" / "turntable" / "turntable_robot")
DRAWN, CHOICES = 5, 4
FIRST_S, MOST_S = 30, 86_400


@given(st.sets(st.integers(0, 60), min_size=1), st.sets(st.integers(0, 60)), st.integers(1, 8), st.integers())
def test_other_questions_come_as_far_as_the_bank_allows(bank, seen, count, seed):
    drawn = quiz.draw(sorted(bank), seen, count, random.Random(seed))
    assert len(drawn) == len(set(drawn)) == min(count, len(bank))
    assert set(drawn) <= bank
    fresh = bank - seen
    assert len(set(drawn) & fresh) == min(len(fresh), len(drawn)), "one seen before only where no other is left"


def test_the_first_failure_costs_nothing_then_the_pause_doubles_up_to_a_day():
    assert [quiz.pause_s(n, FIRST_S, MOST_S) for n in (0, 1, 2, 3, 4, 13, 14, 10**6)] == [
        0, 0, 30, 60, 120, 61_440, 86_400, 86_400,
    ]  # fmt: skip


def attack(rng, paragraphs, tries):
    """Return at which try an attacker passes who remembers what each failed test tells; None if never.

    `paragraphs` has that of each question: a test names those of the wrong answers.
    """
    left = {q: set(range(CHOICES)) for q in range(len(paragraphs))}
    seen: list[int] = []
    for attempt in range(1, tries + 1):
        seen = quiz.draw(range(len(paragraphs)), seen, DRAWN, rng)
        given_ = {q: rng.choice(sorted(left[q])) for q in seen}
        named = {paragraphs[q] for q in seen if given_[q] != 0}
        if not named:
            return attempt
        for q in seen:
            if paragraphs[q] not in named:
                left[q] = {given_[q]}
        for paragraph in named:
            suspects = [q for q in seen if paragraphs[q] == paragraph and len(left[q]) > 1]
            if len(suspects) == 1:  # else the attacker cannot tell which of them it was
                left[suspects[0]].discard(given_[suspects[0]])
    return None


def waited_s(tries):
    """Return the pauses before the last of so many tries (s)."""
    return sum(quiz.pause_s(n, FIRST_S, MOST_S) for n in range(1, tries))


@pytest.mark.asvs("2.3.1", "2.4.1")
@pytest.mark.parametrize("folder", FOLDERS[:6], ids=lambda f: f.name)
def test_guessing_takes_longer_than_reading(folder):
    """Reading takes a minute; in four tries, with pauses of 90 s, one guesser in thirty passes; in seven, with a quarter of an hour, one in five."""
    paragraphs = [(q["section"], q["paragraph"]) for q in bank_of(folder)]
    rng, runs = random.Random(1994), 2000
    passed = [found for found in (attack(rng, paragraphs, 7) for _ in range(runs)) if found]
    assert (waited_s(4), waited_s(7)) == (90, 930)
    assert sum(found <= 4 for found in passed) / runs < 0.03
    assert len(passed) / runs < 0.2
    assert waited_s(10) > 2 * 3600, "half of them need more tries than that"


def test_a_bank_that_is_too_small_would_let_the_guesser_through():
    """The judge can fail: of a bank of which each test asks all, most answers are known after some tries."""
    rng = random.Random(1994)
    assert sum(attack(rng, list(range(DRAWN)), 7) is not None for _ in range(500)) / 500 > 0.5


def bank_of(folder):
    return tomllib.loads((folder / "clearance.toml").read_text())["question"]


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda f: f.name)
def test_each_bank_is_three_times_what_is_drawn_and_points_at_paragraphs_that_exist(folder):
    questions, page = bank_of(folder), render((folder / "orientation.md").read_text())
    assert len(questions) >= 3 * DRAWN
    assert len({q["text"] for q in questions}) == len(questions)
    for question in questions:
        assert (question["section"], question["paragraph"]) in page.anchors, question["text"]
        assert question["section"] != LATER, "what the test asks about is not folded"
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


def test_the_section_for_later_is_folded_in_every_language():
    english = render("# A\n\none\n\n# More, for later\n\n- two\n")
    german = render("# A\n\neins\n\n# Mehr <b>\n\n- zwei\n", tuple(english.headings), "de")
    assert english.html.index("one") < english.html.index("<details>\n<summary>More, for later</summary>\n<ul>")
    assert english.html.endswith("</details>\n")
    assert "<details>\n<summary>Mehr &lt;b&gt;</summary>\n<ul>" in german.html
    assert "<details>" not in render("# A\n\none\n").html


def test_a_control_has_one_number_wherever_the_text_names_it():
    page = render(
        "Press [Up](control:up), then [Down](control:down), then [Up](control:up). [Read](https://example.org)."
    )
    assert page.controls == ("up", "down")
    assert page.html.count('<b class="control" data-number="1">Up</b>') == 2
    assert '<b class="control" data-number="2">Down</b>' in page.html
    assert '<a href="https://example.org">Read</a>' in page.html
