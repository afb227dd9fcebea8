"""Translates sentences that a process wrote in English, with names and numbers already in them.

A worker does not know who reads: its sentences are stored, recorded and sent to many people at once. So they are
translated where they are read. The catalogue has the sentence with placeholders, as "The {name} is off.": a text fits
it if it has the same words around other values. What fits a placeholder is translated by the same rule.
`frontend/src/kit/text.ts` does the same; both are tested against the same vectors.
"""

import re
from collections.abc import Iterator, Mapping
from functools import lru_cache

PLACE = re.compile(r"\{(\w+)\}")
ENDS = (re.compile(r"(?<=[.!?]) "), re.compile(r"(?<=[:;,]) "))  # the parts of a text for which there is no entry
SENTENCES = re.compile(r"[.!?] .*[^.!?]$", re.DOTALL)  # a whole sentence and a part of another
# Names of placeholders: "number…" fits numbers only; what "written…" stands for is code or a person's, and stays; so
# does what "quoted…" stands for, which has quotation marks around it and may be whole sentences.
NUMERAL = re.compile(r"[-+]?[0-9][0-9.e+-]*")
DECIMAL = re.compile(r"^([-+]?[0-9]+)\.([0-9]+)(?=$| |°|%)")  # a measured number, with its unit or without
NUMBER, LETTER, WORD = re.compile(r"[-+]?[0-9]"), re.compile("[A-Za-z]"), re.compile(r"[^\W\d_]")
FEW = 6  # letters; an entry with fewer that begins with a placeholder, as "{low} to {high}", fits numbers only
LONGEST, DEEPEST = 600, 6  # characters; placeholders within placeholders
_Entry = tuple[list[str], list[str], str]  # words around the placeholders, names of these, the translation


class Sentences:
    """The sentences of one language. `catalogue`: the translation of each, empty where there is none.

    `mark` stands between whole part and decimals of a number in a sentence.
    """

    def __init__(self, catalogue: Mapping[str, str], mark: str = ".") -> None:
        self._decimal = rf"\g<1>{mark}\g<2>"
        self._whole = {text: other for text, other in catalogue.items() if other and not PLACE.search(text)}
        self._by_word: dict[str, list[_Entry]] = {}
        entries = [_entry(text, other) for text, other in catalogue.items() if other and PLACE.search(text)]
        for entry in sorted(entries, key=_most_words_first):
            self._by_word.setdefault(_first_word(entry[0][0]), []).append(entry)
        self._any = self._by_word.pop("", [])  # they fit a text whatever its first word is
        for word, own in self._by_word.items():
            self._by_word[word] = sorted((*own, *self._any), key=_most_words_first)
        self.translate = lru_cache(maxsize=4096)(self._translate)

    def whole(self, text: str) -> str:
        """Return the translation of an entry without placeholders; any other text as it is."""
        return self._whole.get(text, text)

    def _translate(self, text: str, depth: int = 0) -> str:
        """Return the text in this language; in English where the catalogue has nothing that fits."""
        if len(text) > LONGEST or depth > DEEPEST:
            return text
        known = self._either(text, depth)
        if known is not None:
            return known
        for end in ENDS:
            first, *rest = end.split(text, 1)
            if rest:
                return " ".join(self._parts(first, rest[0], end, depth + 1))
        bare = text.rstrip(".,:;")
        return self._translate(bare, depth + 1) + text[len(bare) :] if bare != text else text

    def _parts(self, first: str, text: str, end: re.Pattern[str], depth: int) -> Iterator[str]:
        """Yield the translations of the parts of a text: what follows a part may fit an entry as a whole."""
        while True:
            yield self._translate(first, depth)
            first, *rest = end.split(text, 1) if self._either(text, depth) is None else [text]
            if not rest:
                yield self._translate(first, depth)
                return
            text = rest[0]

    def _either(self, text: str, depth: int) -> str | None:
        """Return `_known`, also with the first letter in the other case: a sentence may stand in another."""
        known = self._known(text, depth)
        if known is None and LETTER.match(text):
            known = self._known(text[0].swapcase() + text[1:], depth)
            known = known[:1].upper() + known[1:] if known and text[0].isupper() else known
        if known is None and SENTENCES.search(text) and not text.endswith(":"):  # its last full stop is another's
            known = self._either(f"{text}.", depth)
            return known.removesuffix(".") if known else known
        return known

    def _known(self, text: str, depth: int) -> str | None:
        """Return the translation of an entry that fits the whole text."""
        if text in self._whole:
            return self._whole[text]
        for words, names, other in self._candidates(text):
            values = fit(words, text)
            if values is not None and all(
                self._may_be(name, value, depth) for name, value in zip(names, values, strict=True)
            ):
                known = {name: self._value(name, value, depth) for name, value in zip(names, values, strict=True)}
                return PLACE.sub(lambda place, known=known: known.get(place[1], place[0]), other)  # type: ignore[misc]
        return None

    def _value(self, name: str, value: str, depth: int) -> str:
        if name.startswith(("written", "quoted")):
            return value
        return self._translate(DECIMAL.sub(self._decimal, value), depth + 1)

    def _may_be(self, name: str, value: str, depth: int) -> bool:
        """Tell whether the placeholder may stand for the value: a number; no sentence and a part of the next one."""
        if name.startswith("number"):
            return bool(NUMERAL.fullmatch(value))
        return (
            name.startswith("quoted")
            or not SENTENCES.search(value)
            or (depth < DEEPEST and self._either(value, depth + 1) is not None)
        )

    def _candidates(self, text: str) -> list[_Entry]:
        return self._by_word.get(text.split(" ", 1)[0], self._any)


def fit(words: list[str], text: str) -> list[str] | None:
    """Return what stands between the words, at least one character each; None if the text has other words."""
    first, *middle, last = words
    numbers = not first and len(WORD.findall(" ".join(words))) < FEW
    if not text.startswith(first) or not text.endswith(last) or len(text) < len(first) + len(last):
        return None
    values, at, end = [], len(first), len(text) - len(last)
    for word in middle:
        found = text.find(word, at + 1, end)
        if found < 0:
            return None
        values.append(text[at:found])
        at = found + len(word)
    values.append(text[at:end])
    if (
        WORD.search(last) and last in values[-1]
    ):  # the text has the sentence twice, as "the lamp is off, the arm is off"
        return None
    return values if at < end and (not numbers or all(map(NUMBER.match, values))) else None


def _entry(text: str, other: str) -> _Entry:
    parts = PLACE.split(text)
    return parts[::2], parts[1::2], other


def _most_words_first(entry: _Entry) -> tuple[int, str]:
    return -sum(map(len, entry[0])), "\0".join(entry[0])


def _first_word(start: str) -> str:
    """Return the first word of the text before the first placeholder, if it is complete."""
    word, space, _ = start.partition(" ")
    return word if space else ""
