"""Sentences of workers, stored and sent in English, in the language of the person who reads."""

from decimal import Decimal
from functools import cache
from math import isfinite
from typing import Any

from django.conf import settings
from django.utils.formats import get_format, number_format
from django.utils.translation import get_language, override
from django.utils.translation.trans_real import DjangoTranslation

from robots.kit.contract.ranges import readable
from robots.kit.sentences import Sentences

DOMAIN = "djangojs"  # the page's scripts have the same catalogue


@cache
def _sentences(language: str) -> Sentences:
    catalogue = DjangoTranslation(language, domain=DOMAIN)._catalog  # type: ignore[attr-defined] # as Django's own view does
    texts = {text: other for text, other in catalogue.items() if isinstance(text, str) and text}
    return Sentences(texts, get_format("DECIMAL_SEPARATOR", lang=language))


def _of_reader() -> Sentences | None:
    """Return the sentences of the reader's language; None for English."""
    language = get_language() or settings.LANGUAGE_CODE
    return None if language == settings.LANGUAGE_CODE else _sentences(language)


def translate(text: Any) -> str:
    """Return a sentence of a worker, a label of a spec or a text of a robot's package in the reader's language."""
    sentences = _of_reader()
    return str(text) if sentences is None else sentences.translate(str(text))


def declared(text: Any) -> str:
    """Return a text of a robot's package in the reader's language; what staff wrote in its place stays."""
    sentences = _of_reader()
    return str(text) if sentences is None else sentences.whole(str(text))


def in_digits(number: float) -> str:
    """Return a measured or given number as people read it, with the decimal mark of the reader's language."""
    return number_format(Decimal(readable(number))) if isfinite(number) else readable(number)


def english(label: Any) -> str:
    """Return a label as it is stored and sent to many people: in English, whoever asks."""
    with override(settings.LANGUAGE_CODE):
        return str(label)
