"""Reads what people type: whole numbers, texts that every database can store, and names."""

import re
import unicodedata

DIGITS = 18  # these fit into a database integer
NUMERAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")  # of a decimal number, as pages read it, too


def whole(text: str) -> int | None:
    """Return a whole number written in ASCII digits; None for anything else or for too many digits."""
    return int(text) if text.isascii() and text.isdigit() and len(text) <= DIGITS else None


def storable(text: str) -> bool:
    """Return whether a database can store the text: it has no NUL and no unpaired surrogate."""
    return "\0" not in text and not any("\ud800" <= letter <= "\udfff" for letter in text)


def plain_breaks(text: str) -> str:
    """Return the text with line breaks of one character, as browsers count them; a form sends two, CR and LF."""
    return text.replace("\r\n", "\n").replace("\r", "\n")


def one_line(name: str) -> str:
    """Return a name as others may read it: without control characters, nor such as are invisible or turn the text."""
    kept = (" " if letter.isspace() else letter for letter in unicodedata.normalize("NFKC", name))
    return " ".join("".join(letter for letter in kept if unicodedata.category(letter)[0] != "C").split())
