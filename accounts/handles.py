"""Handles: rules for names, so that nobody can pretend to be staff, a robot or another person."""

import re
import unicodedata
from functools import cache, lru_cache, reduce
from typing import Any

from django.contrib.auth import get_user_model
from django.core.exceptions import ValidationError
from django.db import models
from django.db.models import Q
from django.utils.text import format_lazy
from django.utils.translation import gettext, gettext_lazy

from robots.models import Robot

SHORTEST, LONGEST = 2, 24
DIGITS = "0123456789"
RULES = format_lazy(
    gettext_lazy(
        "Shown to others when you drive. {shortest} to {longest} letters of one script, digits, and . - _ between "
        "them. Not the name of a robot or of a role, such as admin or staff."
    ),
    shortest=SHORTEST, longest=LONGEST,
)  # fmt: skip
RESERVED = frozenset({
    "admin", "administrator", "anonymous", "deleted", "everybody", "everyone", "farhand", "guest", "help", "me",
    "moderator", "moderators", "nobody", "null", "operator", "portal", "robot", "robots", "root", "security",
    "somebody", "staff", "superuser", "support", "system", "undefined", "webmaster",
})  # fmt: skip
ROLES = RESERVED - {
    "anonymous", "deleted", "everybody", "everyone", "guest", "help", "me", "nobody", "null", "somebody", "undefined",
}  # fmt: skip
JOINED = ({"HIRAGANA", "KATAKANA", "CJK", "KATAKANA-HIRAGANA"}, {"HANGUL", "CJK"})  # used together by one language
# characters that people read as a letter but Unicode's table does not: digits, i beside I and l; and, in ALSO, the
# prototypes that the table has for letters such as ε and м
READ_AS = str.maketrans("i10234578", "llozeastb")
ALSO = str.maketrans({"ꞓ": "e", "χ": "x", "ĸ": "k", "ʍ": "rn"})
SYMBOLS = str.maketrans("@$!¡|€", "asllle")  # no handle has them
LAST_SYMBOLS = re.compile(r"[@$!¡|€]+(?!\w)")
AROUND = tuple(re.compile(digits) for digits in ("", r"\A\d+", r"\d+\Z", r"\A\d+|\d+\Z"))
DRAWN_AS = re.compile(r"LATIN (?:CAPITAL LETTER|SMALL LETTER|LETTER SMALL CAPITAL) ([A-Z])(?: WITH .*)?")
LONGEST_KEY = 240
LRM = "\u200e"  # around letters of scripts that run from right to left, in the package's data


def normal(handle: str) -> str:
    """Return the stored form of the handle: NFKC, so that variants such as full-width letters become one."""
    return unicodedata.normalize("NFKC", handle).strip()


def key(handle: str) -> str:
    """Return a key that is the same for handles that look alike: UTS 39's skeleton, without case and accents.

    The case is folded after a first pass, because the capitals I and Ν (Greek) look like other letters than i and ν do.
    """
    return _skeleton(_skeleton(normal(handle)).casefold()).translate(READ_AS)[:LONGEST_KEY]


def is_taken(handle: str, but: Any = None) -> bool:
    """Return whether a person other than `but` (a primary key) has the handle, or one that looks like it."""
    keys = {key(variant) for variant in (handle, handle.lower(), handle.upper())}
    alike = Q(handle_key__in=keys)
    for one in keys:
        alike |= Q(handle_key__startswith=f"{one}#")
    return get_user_model().objects.filter(alike).exclude(pk=but).exists()


@cache
def _prototypes() -> dict[str, str]:
    """Return Unicode's confusables: each character with its prototype, one for all characters that look alike.

    The package lists each pair in both directions. A prototype is the one that several characters look like, or is
    several letters long.
    """
    from confusable_homoglyphs.confusables import confusables_data  # noqa: PLC0415 - 1 MB that few processes need

    near: dict[str, set[str]] = {}
    for letter, found in confusables_data.items():
        near.setdefault(letter.strip(LRM), set()).update(one["c"].strip(LRM) for one in found)
    prototypes = {}
    for letter, others in near.items():
        if len(letter) == len(others) == 1:
            (other,) = others
            prototypes[letter] = other if len(other) > 1 or len(near[other]) > 1 else min(letter, other)
    return prototypes


def _skeleton(text: str) -> str:
    prototypes = _prototypes()
    plain = "".join([prototypes.get(c, c) for c in _bare_of_accents(text)])
    return "".join(map(_drawn, _bare_of_accents(plain).translate(ALSO)))


def _bare_of_accents(text: str) -> str:
    if text.isascii():
        return text
    apart = unicodedata.normalize("NFD", text)
    return "".join([c for c in apart if not unicodedata.combining(c) or not _accent(unicodedata.combining(c))])


def _accent(place: int) -> bool:
    """Return whether marks of this combining class are accents or points, and not vowel signs of other scripts."""
    return place == 1 or 10 <= place <= 35 or place >= 200


@lru_cache(maxsize=4096)
def _drawn(letter: str) -> str:
    """Return `b` for a small capital ʙ and for a ɓ with a hook."""
    found = None if letter.isascii() else DRAWN_AS.fullmatch(unicodedata.name(letter, ""))
    return found[1].lower() if found else letter


def _script(letter: str) -> str:
    return unicodedata.name(letter, "UNNAMED").split()[0]


def validate(handle: str) -> None:
    """Refuse an invalid new handle. Raises ValidationError with a sentence. Older handles stay valid."""
    handle = normal(handle)
    if not SHORTEST <= len(handle) <= LONGEST:
        said = gettext("Use {shortest} to {longest} characters.")
        raise ValidationError(said.format(shortest=SHORTEST, longest=LONGEST))
    scripts = set()
    for letter in handle:
        if letter in DIGITS + ".-_":
            continue
        script, kind = _script(letter), unicodedata.category(letter)
        drawn = kind[0] in "LM" and kind != "Me" and "FILLER" not in unicodedata.name(letter, "")
        if not drawn or script in ("COMBINING", "UNNAMED"):
            raise ValidationError(
                gettext("Use letters, digits and . - _ only; no spaces, symbols or invisible characters.")
            )
        scripts.add(script)
    if len(scripts) > 1 and not any(scripts <= joined for joined in JOINED):
        mixed = reduce(_and, map(_script_name, sorted(scripts)))
        raise ValidationError(gettext("Use letters of one script; this mixes {scripts}.").format(scripts=mixed))
    if not scripts or handle[0] in ".-_" or handle[-1] in ".-_":
        raise ValidationError(gettext("Use at least one letter, and begin and end with a letter or a digit."))
    if _reads_as(handle, _reserved(RESERVED)):
        raise ValidationError(gettext("That handle is reserved; choose another one."))


def _script_name(script: str) -> str:
    """Return the name of a script; in English if people seldom mix it with others."""
    names = {"LATIN": gettext("Latin"), "GREEK": gettext("Greek"), "CYRILLIC": gettext("Cyrillic")}
    return names.get(script, script.title())


def _and(some: str, other: str) -> str:
    return gettext("{some} and {other}").format(some=some, other=other)


def claims_role(name: str) -> bool:
    """Return whether a free name shows a role or a robot: in brackets, among other words, or spaced out.

    Symbols are read as letters too; at the end of a word they may also be punctuation.
    """
    reserved, name = _reserved(ROLES), normal(name)
    readings = (name, name.translate(SYMBOLS), LAST_SYMBOLS.sub("", name).translate(SYMBOLS))
    words = {word for text in readings for word in (text, *re.split(r"[\W_]+", text))}
    return any(_reads_as(word, reserved) for word in words)


def _reads_as(text: str, reserved: set[str]) -> bool:
    """Return whether a text reads as one of these words, also with digits before or after it."""
    return any(_bare(digits.sub("", text)) in reserved for digits in AROUND)


@cache
def _bare_words(words: frozenset[str]) -> frozenset[str]:
    return frozenset(map(_bare, words))


def _reserved(words: frozenset[str]) -> set[str]:
    """Return the plain letters of these words and of the robots' names and slugs."""
    robots = (name for row in Robot.objects.values_list("slug", "name") for name in row)
    return {*_bare_words(words), *map(_bare, robots)} - {""}


def _bare(handle: str) -> str:
    return re.sub(r"[\W_]", "", key(handle))


VALIDATORS = [validate]


class HandleKey(models.CharField):  # type: ignore[type-arg]
    """The key of the handle, unique among people and written with the handle.

    If two older accounts have the same key, the younger one has `#` and its number after the key.
    """

    def pre_save(self, model_instance: models.Model, add: bool) -> Any:
        """Return the key of the present handle."""
        found, kept = key(str(getattr(model_instance, "username", ""))), getattr(model_instance, self.attname)
        if not str(kept or "").startswith(f"{found}#"):
            setattr(model_instance, self.attname, found)
        return getattr(model_instance, self.attname)
