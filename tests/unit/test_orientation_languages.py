"""A translated orientation has the sections, paragraphs and controls of the English one, in the same order."""

import re

import pytest

from accounts.orientation import anchor, render
from tests.environment import ROOT

TRANSLATED = sorted([*ROOT.glob("robots/kit/drivers/*/orientation.*.md"), *ROOT.glob("tests/packages/*/*/orientation.*.md")])  # fmt: skip
PART = re.compile(r'<(?:p|li)(?: id="([^"]+)")?>|<h(\d)>|data-number="(\d+)"')
ENGLISH = "# The arm\n\nPress [Up](control:up).\n\n- one\n- two\n\n# Rest\n\nNothing."
GERMAN = "# Der Arm\n\nDrücken Sie [Auf](control:up).\n\n- eins\n- zwei\n\n# Ruhe\n\nNichts."


@pytest.mark.parametrize("path", TRANSLATED, ids=lambda p: f"{p.parent.name}-{p.name}")
def test_a_translation_is_parallel_to_the_english_text(path):
    english = render((path.parent / "orientation.md").read_text())
    found = render(path.read_text(), tuple(english.headings), path.name.split(".")[1])
    assert list(found.headings) == list(english.headings)
    assert found.anchors == english.anchors
    assert found.controls == english.controls
    assert PART.findall(found.html) == PART.findall(english.html), "paragraphs, and the controls that each names"


def test_a_translation_has_the_anchors_of_the_english_text_and_its_own_headings():
    english = render(ENGLISH)
    german = render(GERMAN, tuple(english.headings), "de")
    assert german.anchors == english.anchors
    assert f'<p id="{anchor("Rest", 1)}">Nichts.</p>' in german.html
    assert german.headings == {"The arm": "Der Arm", "Rest": "Ruhe"}
    assert (english.language, german.language) == ("en", "de")
