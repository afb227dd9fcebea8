"""Every text has a translation: of the catalogues' own entries, and of what the sources have now."""

import re

import pytest

from tools import translations
from tools.translations import ROOT

DOMAINS = {"django": translations.marked, "djangojs": translations.unmarked}


@pytest.mark.parametrize("domain", DOMAINS)
def test_every_text_of_the_sources_is_translated(domain):
    found = DOMAINS[domain]()
    for path in translations.catalogues(domain, None):
        catalogue = translations.read(path)
        wanted = {(message.context, message.id) for message in found if message.id}
        assert wanted == {(message.context, message.id) for message in catalogue if message.id}, "make it anew: update"
        assert not translations.gaps(catalogue)


def test_no_style_has_words():
    """They would be English for everybody; an attribute of the element has them."""
    files = [file for folder in ("frontend/src", "robots/kit/drivers") for file in (ROOT / folder).rglob("*.css")]
    assert [
        (file.name, words)
        for file in files
        for words in re.findall(r'content: "[^"]*[A-Za-z]{3}[^"]*"', file.read_text())
    ] == []
    assert len(files) > 10
