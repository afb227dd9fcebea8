"""The words below a movie: the time, the step, and the newest readings. Pure. No Django."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from robots.kit.recording.container import Message, nameless

ENDS = {"completed": "done", "failed": "failed", "cancelled": "cancelled", "unknown": "nobody knows how it ended"}
LONGEST = 200  # characters of a line
TOGETHER = "\xa0"  # a space at which no line ends


def utc(at_ms: int) -> str:
    """Return a time for people."""
    return f"{datetime.fromtimestamp(at_ms / 1000, UTC):%Y-%m-%d %H:%M:%S} UTC"


class Captions:
    """Follows a recording's commands; `notes` are times (ms since 1970), each with what was measured then.

    `labels`: what each kind of command is called.
    """

    def __init__(self, notes: Sequence[tuple[int, str]], labels: Mapping[str, str]) -> None:
        self._notes, self._labels = sorted((at, words) for at, words in notes if words), labels
        self._step = ""

    def take(self, message: Message) -> None:
        """Take a stage of a command; one that cannot be read changes nothing."""
        try:
            told = nameless(message).content()
        except ValueError:
            return
        words, state, kind = _progress(told), str(told.get("state")), str(told.get("kind"))
        if state in ENDS:
            self._step = _shown(f"{self._labels.get(kind, kind)}: {ENDS[state]}")
        elif words:
            self._step = _shown(words)
        elif state in ("sent", "acknowledged"):
            self._step = _shown(self._labels.get(kind, kind))

    def at(self, at_ms: int) -> tuple[str, str, str]:
        """Return the three lines: the time, the step, the newest readings."""
        read = [f"{utc(at)[11:19]}  {words}" for at, words in self._notes if at <= at_ms]
        return utc(at_ms), self._step, _shown(read[-1]) if read else ""


def _progress(told: Mapping[str, Any]) -> str:
    progress = told.get("progress")
    return str(progress.get("text") or "") if isinstance(progress, Mapping) else ""


def _shown(words: str) -> str:
    """Return a text that a font can write: one line, not too long."""
    return "".join(c if c.isprintable() or c == TOGETHER else " " for c in words)[:LONGEST]


def wrapped(words: str, fits: int, most: int) -> list[str]:
    """Return at most so many lines of at most `fits` characters; what is left over ends in an ellipsis."""
    found: list[str] = []
    line = ""
    for word in filter(None, words.split(" ")):
        longer = f"{line} {word}".strip()
        if len(longer) <= fits or not line:
            line = longer
            continue
        found, line = [*found, line[:fits]], word
    found = [*found, line[:fits]] if line else found
    if len(found) > most:
        return [*found[: most - 1], f"{found[most - 1][: fits - 1].rstrip()}…"]
    return found
