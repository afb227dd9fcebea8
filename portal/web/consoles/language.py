"""The description of a robot in the reader's language, where its page is rendered."""

from typing import Any

from robots.sentences import translate

LABELS = frozenset({"label", "labels", "help", "title", "directions", "words"})  # nothing that a script compares


def in_language(facts: Any, label: bool = False) -> Any:
    """Return a description with its labels in the reader's language. Names, kinds and texts of programs stay."""
    if isinstance(facts, dict):
        return {key: in_language(value, label or key in LABELS) for key, value in facts.items()}
    if isinstance(facts, list | tuple):
        return [in_language(value, label) for value in facts]
    return translate(facts) if label and isinstance(facts, str) else facts
