"""Robots' pages have plain words for what the robots call by letters and numbers."""

import re

import pytest

from robots.kit.contract.find import spec_of
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
