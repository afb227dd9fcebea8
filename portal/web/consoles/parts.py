"""The parts of a robot's console, cut out of its template, so that the page puts them in their places beside Stop."""

NAMES = ("look", "screen", "buttons", "beside", "body")


def parts(text: str, cut: str) -> dict[str, str]:
    """Return the parts by name; `cut` stands around each name in what `consoles/frame.html` wrote.

    A console that does not extend that template has no parts: all of it is the body.
    """
    outside, *pieces = text.split(cut)
    found = dict(zip(pieces[::2], pieces[1::2], strict=False)) if pieces else {"body": outside}
    return {name: found.get(name, "").strip() for name in NAMES}
