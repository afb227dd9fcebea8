"""Waits and lengths of time in words. The pages' scripts use the same words (`frontend/src/words.ts`)."""

from math import ceil

UNKNOWN = "the wait is not known now"


def wait_words(wait: tuple[int, int] | None) -> str:
    """Return the least and greatest wait (s) in words; None where nobody knows."""
    if wait is None:
        return UNKNOWN
    low, high = wait
    if high < 10:
        return "any moment now"
    if high < 60:
        return "less than a minute"
    if low < 60:
        return f"at most {_rounded(high)}"
    near, far = _rounded(low), _rounded(high)
    return f"about {far}" if near == far else f"about {near} to {far}"


def wait_said(wait: tuple[int, int] | None) -> str:
    """Return the same as a sentence."""
    words = wait_words(wait)
    return f"{words[:1].upper()}{words[1:]}{'; your place is kept' if wait is None else ''}."


def _rounded(seconds: int) -> str:
    return f"{ceil(seconds / 60)} min" if seconds < 5400 else f"{ceil(seconds / 3600)} h"


def length_words(seconds: float) -> str:
    """Return a length of time as it is charged, as "2 min 5 s"."""
    minutes, rest = divmod(round(max(0.0, seconds)), 60)
    return f"{minutes} min {rest} s" if minutes and rest else f"{minutes} min" if minutes else f"{rest} s"
