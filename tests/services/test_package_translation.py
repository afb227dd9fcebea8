"""The package of a robot brings translations of its own texts, which the portal uses as soon as it is installed."""

import shutil

import pytest
from babel.messages.pofile import write_po
from django.utils.translation import gettext, override, trans_real

from portal.web.translation import views
from robots import sentences
from robots.kit import installed
from tests.packaged import TURNTABLE, installed_from
from tools import translations

TAGLINE, QUESTION = "One axis, no camera: the smallest robot there is", "Has it a camera?"
GERMAN = {TAGLINE: "Eine Achse, keine Kamera", QUESTION: "Hat er eine Kamera?"}
CACHES = (sentences._sentences, views._script, views.version_of)


def forget():
    for cache in CACHES:
        cache.cache_clear()
    trans_real._translations.clear()


@pytest.fixture
def package(tmp_path, monkeypatch):
    """The package of the turntable with German texts, installed."""
    folder = shutil.copytree(TURNTABLE, tmp_path / "it", ignore=shutil.ignore_patterns("__pycache__"))
    with installed_from(folder, monkeypatch):
        yield folder / "turntable_robot"
    forget()


def translated(package):
    translations.update(package)
    for domain in ("django", "djangojs"):
        for path in translations.catalogues(domain, package):
            catalogue = translations.read(path)
            for message in catalogue:
                message.string = GERMAN.get(message.id, message.string)
            with path.open("wb") as file:
                write_po(file, catalogue)
    return translations.compile_all(package)


def test_its_texts_are_found_translated_and_used(package, settings, capsys):
    assert translated(package) == 0
    assert translations.missing(package) == 1
    missing = capsys.readouterr().out
    assert "django.po: 'How many axes has it?'" in missing and TAGLINE not in missing
    assert installed.catalogues() == [package / "locale"]
    settings.LOCALE_PATHS = [*settings.LOCALE_PATHS, *installed.catalogues()]
    forget()
    with override("de"):
        assert sentences.translate(TAGLINE) == GERMAN[TAGLINE]
        assert gettext(QUESTION) == GERMAN[QUESTION]
    assert GERMAN[TAGLINE] in views._script("de").decode()
    assert not (package / "locale" / "ar_XB").exists()


def test_a_package_without_translations_adds_no_folder(package):
    assert installed.catalogues() == []
