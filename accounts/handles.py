"""Handles: rules for names, so that nobody can pass for staff, for a robot or for another person."""

import re
import unicodedata
from typing import Any

from django.core.exceptions import ValidationError
from django.db import models

from robots.models import Robot

SHORTEST, LONGEST = 2, 24
RULES = (
    f"Shown to others when you drive. {SHORTEST} to {LONGEST} letters of one script, digits, and . - _ between them. "
    "Not the name of a robot or of a role, such as admin or staff."
)
RESERVED = frozenset({
    "admin", "administrator", "anonymous", "everybody", "everyone", "farhand", "guest", "help", "me", "moderator",
    "moderators", "nobody", "null", "operator", "portal", "robot", "robots", "root", "security", "staff", "superuser",
    "support", "system", "undefined", "webmaster",
})  # fmt: skip
JOINED = (
    {"HIRAGANA", "KATAKANA", "CJK", "KATAKANA-HIRAGANA"},
    {"HANGUL", "CJK"},
)  # used together by one language
# lower-case letters of other scripts that look like Latin ones
ALIKE = str.maketrans("асеорхуіјѕԁһӏԛԝοενρικχυ", "aceopxyijsdhlqwoevpikxu")


def normal(handle: str) -> str:
    """Return the stored form of the handle: NFKC, so that variants such as full-width letters become one."""
    return unicodedata.normalize("NFKC", handle).strip()


def key(handle: str) -> str:
    """Return a key that is the same for handles that look alike."""
    return normal(normal(handle).casefold()).translate(ALIKE)


def _script(letter: str) -> str:
    return unicodedata.name(letter, "UNNAMED").split()[0]


def validate(handle: str) -> None:
    """Refuse an invalid new handle; older ones stay. Raises ValidationError with a sentence."""
    handle = normal(handle)
    if not SHORTEST <= len(handle) <= LONGEST:
        raise ValidationError(f"Use {SHORTEST} to {LONGEST} characters.")
    scripts = set()
    for letter in handle:
        if letter in "0123456789.-_":
            continue
        script, kind = _script(letter), unicodedata.category(letter)
        drawn = kind[0] in "LM" and kind != "Me" and "FILLER" not in unicodedata.name(letter, "")
        if not drawn or script in ("COMBINING", "UNNAMED"):
            raise ValidationError("Use letters, digits and . - _ only; no spaces, symbols or invisible characters.")
        scripts.add(script)
    if len(scripts) > 1 and not any(scripts <= joined for joined in JOINED):
        mixed = " and ".join(sorted(script.title() for script in scripts))
        raise ValidationError(f"Use letters of one script; this mixes {mixed}.")
    if not scripts or handle[0] in ".-_" or handle[-1] in ".-_":
        raise ValidationError("Use at least one letter, and begin and end with a letter or a digit.")
    bare = _bare(handle)
    robots = {_bare(name) for row in Robot.objects.values_list("slug", "name") for name in row}
    if bare in RESERVED or bare.strip("0123456789") in RESERVED or bare in robots:
        raise ValidationError("That handle is reserved; choose another one.")


def _bare(handle: str) -> str:
    return re.sub(r"[\s._-]", "", key(handle))


VALIDATORS = [validate]


class HandleKey(models.CharField):  # type: ignore[type-arg]
    """The key of the handle, unique among people and written with the handle.

    An older account whose key equals an even older one's has `#` and its number behind the key.
    """

    def pre_save(self, model_instance: models.Model, add: bool) -> Any:
        """Return the key of the present handle."""
        found, kept = key(str(getattr(model_instance, "username", ""))), getattr(model_instance, self.attname)
        if not str(kept or "").startswith(f"{found}#"):
            setattr(model_instance, self.attname, found)
        return getattr(model_instance, self.attname)
