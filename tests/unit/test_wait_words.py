"""Waits and lengths of time in words, for every number there may be."""

import json
import re
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from queueing.words import join_said, wait_said, wait_words
from robots.dates import length_words

VECTORS = json.loads((Path(__file__).parents[1] / "vectors/waits.json").read_text())
JOINS = json.loads((Path(__file__).parents[1] / "vectors/joins.json").read_text())
SECONDS = st.integers(0, 200_000)


def test_a_wait_is_said_as_the_pages_scripts_say_it():
    for one in VECTORS:
        assert wait_said(one["wait"] and tuple(one["wait"])) == one["said"]


def test_the_wait_of_somebody_who_joins_is_said_as_the_pages_scripts_say_it():
    for one in JOINS:
        assert join_said(one["state"], one["free"], one["wait"] and tuple(one["wait"])) == one["said"]


@given(SECONDS, SECONDS)
def test_no_wait_is_said_with_a_zero_a_fraction_or_a_range_of_one(one, other):
    low, high = sorted((one, other))
    words = wait_words((low, high))
    assert not re.search(r"\b0\b|\.|-", words), words
    assert words and words == words.strip()
    told = re.findall(r"(\d+) (min|h)", words)
    assert len(set(told)) == len(told), "about 2 min to 2 min"
    longest = [int(number) * {"min": 60, "h": 3600}[unit] for number, unit in told]
    if longest:
        assert high <= longest[-1] < high + 3600 * (high >= 5400) + 60 * (high < 5400), "nobody waits longer than said"
        assert low <= longest[0] or len(longest) == 1


@given(SECONDS, SECONDS, st.integers(0, 5000))
def test_a_longer_wait_is_never_said_to_be_shorter(low, spread, more):
    def most(high):
        words = wait_words((low, high))
        told = re.findall(r"(\d+) (min|h)", words)
        at = ("any moment now", "less than a minute").index(words) if not told else 0
        return int(told[-1][0]) * {"min": 60, "h": 3600}[told[-1][1]] if told else at

    assert most(low + spread) <= most(low + spread + more)


@given(st.floats(0, 1e6))
def test_a_length_of_time_can_be_read_back(seconds):
    words = length_words(seconds)
    read = sum(int(n) * {"min": 60, "s": 1}[unit] for n, unit in re.findall(r"(\d+) (min|s)", words))
    assert read == round(seconds)
    assert seconds < 0.5 or not re.search(r"\b0\b", words)
