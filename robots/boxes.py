"""Forbidden boxes as staff write them: JSON in a form field, checked with sentences."""

import re
from typing import Any

from django import forms
from django.forms.fields import InvalidJSONInput

MOST_BOXES = 20


class JSONField(forms.JSONField):
    """Django's field, which also refuses JSON that is nested too deep or has numbers of thousands of digits."""

    def to_python(self, value: Any) -> Any:
        """Return the parsed value. Raises ValidationError."""
        try:
            return super().to_python(value)
        except (ValueError, RecursionError) as error:
            raise forms.ValidationError("Write a list of boxes as JSON.") from error

    def bound_data(self, data: Any, initial: Any) -> Any:
        """Return the text that the form shows again."""
        try:
            return super().bound_data(data, initial)
        except (ValueError, RecursionError):
            return InvalidJSONInput(data)


def checked(found: Any) -> list[dict[str, Any]]:
    """Return forbidden boxes with each low corner below its high corner. Raises ValidationError with a sentence."""
    if not isinstance(found, list) or len(found) > MOST_BOXES:
        raise forms.ValidationError(f"Write a list of at most {MOST_BOXES} boxes.")
    tidy = []
    for number, box in enumerate(found, 1):
        name = box.get("name") if isinstance(box, dict) else None
        if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z0-9 -]{1,30}", name):
            raise forms.ValidationError(f"Box {number} needs a name of letters, digits and spaces.")
        corners = [box.get("low"), box.get("high")]
        if not all(isinstance(c, list) and len(c) == 3 and all(_metres(v) for v in c) for c in corners):
            raise forms.ValidationError(f"{name}: low and high are corners of three numbers each, at most 5 m away.")
        low, high = ([f(a, b) for a, b in zip(*corners, strict=True)] for f in (min, max))
        if any(b - a < 0.001 for a, b in zip(low, high, strict=True)):
            raise forms.ValidationError(f"{name} must be at least one millimetre thick.")
        tidy.append({"name": name, "low": low, "high": high})
    return tidy


def _metres(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= 5
