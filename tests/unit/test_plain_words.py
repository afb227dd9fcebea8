"""Robots' pages have plain words for what the robots call by letters and numbers."""

import re

import pytest

from robots.kit.contract.find import spec_of
from robots.kit.contract.words import command_words
from robots.kit.description import load
from robots.kit.installed import drivers

OWN = re.compile(r"[A-Za-z]?\d+|[A-Z ]{4,}")  # S1, q2, NO CTRL


@pytest.mark.parametrize("driver", drivers())
def test_each_joint_and_mode_that_is_called_by_letters_has_a_plain_word(driver):
    spec = spec_of(driver)
    own = {name for name in (*spec.joints, *spec.modes) if OWN.fullmatch(name)}
    words = load(driver).get("words", {})
    assert own <= set(words)
    assert all(word and not OWN.fullmatch(word) for word in words.values())


@pytest.mark.parametrize("driver", drivers())
def test_sentences_of_commands_have_the_plain_words_of_joints_and_not_their_letters(driver):
    spec, words = spec_of(driver), load(driver).get("words", {})
    for command in spec.commands:
        for name in (one.name for one in command.arguments if one.name in words):
            said = command_words(spec, command.kind, {name: 0.3})
            assert words[name].lower() in said.lower()
            assert not re.search(rf"\b{name}\b", said)
