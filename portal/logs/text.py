"""Text in logs: of a bounded size, without control characters."""

PRINTED = 2000  # bytes of a line that another process prints


def escaped(text: str) -> str:
    r"""Return the text with whatever could begin, erase or turn a line (\n, \r, ESC, C1, U+2028, bidi) as escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def bounded(text: str, size: int, end: int = 0) -> str:
    """Return at most about `size` bytes of the text: its beginning, and `end` bytes of its end."""
    data = text.encode(errors="backslashreplace")
    if len(data) <= size:
        return text
    begin, tail = data[: size - end].decode(errors="ignore"), data[len(data) - end :].decode(errors="ignore")
    return f"{begin} ... ({len(data) - size} bytes left out) ... {tail}".rstrip()


def tidy(text: str, size: int) -> str:
    """Return one line of at most about `size` bytes, escaped."""
    cut = text[:size]  # first, because a text of strangers may have megabytes
    more = f" ... ({len(text) - size} characters left out)" if len(text) > size else ""
    return bounded(escaped(cut), size) + more
