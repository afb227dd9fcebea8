"""Every text has a translation: of the catalogues' own entries, and of what the sources have now."""

import pytest

from tools import translations

DOMAINS = {"django": translations.marked, "djangojs": translations.unmarked}


@pytest.mark.parametrize("domain", DOMAINS)
def test_every_text_of_the_sources_is_translated(domain):
    found = DOMAINS[domain]()
    for path in translations.catalogues(domain, None):
        catalogue = translations.read(path)
        wanted = {(message.context, message.id) for message in found if message.id}
        assert wanted == {(message.context, message.id) for message in catalogue if message.id}, "make it anew: update"
        assert not translations.gaps(catalogue)
