"""What people type, read once and for all: whole numbers, and texts that every store can keep."""

DIGITS = 18  # what fits into a row's number


def whole(text: str) -> int | None:
    """Return a whole number written in ASCII digits; None for anything else, and for more digits than a row holds."""
    return int(text) if text.isascii() and text.isdigit() and len(text) <= DIGITS else None


def storable(text: str) -> bool:
    """Tell whether a database keeps the text: no NUL, no half of a character."""
    return "\0" not in text and not any("\ud800" <= letter <= "\udfff" for letter in text)
