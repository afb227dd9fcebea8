"""Forms of the admin as a browser has them: what is filled in, and what a person could write instead."""

from dataclasses import dataclass, field
from html.parser import HTMLParser

TEXTS = ("", "Ünï <b>& 漢字")
DATES, TIMES = ("", "1970-01-01", "2199-12-31"), ("", "23:59:59")
MOST_OPTIONS = 3
SENSIBLE = {  # where hardly any text is taken
    "email": ("new@example.org",), "username": ("ada-l",), "slug": ("another",), "user": ("2",),
    "driver": ("irat", "pa10", "mercury"), "address": ("tcp:arm.example.org:9000", "serial:/dev/ttyUSB0"),
    "camera": ("http://camera.example.org/a.jpg", "rtsp://a.example.org/x\nv4l2:/dev/video0"),
    "microphone": ("sim:microphone", "http://sound.example.org/a"), "turn_s": ("10", "86400"),
    "setting_still_exposure_s": ("0.01", "0.02"), "last_login_0": ("2026-01-02",),
}  # fmt: skip


@dataclass
class Control:
    """A field: its name, kind, the value that it is sent with (None: it is not sent), and its other choices."""

    name: str
    kind: str
    value: str | list[str] | None = None
    options: list[str] = field(default_factory=list)
    low: str = ""
    high: str = ""
    longest: int = 0


class Controls(HTMLParser):
    """The controls of the page's form that saves."""

    def __init__(self, html):
        super().__init__()
        self.found, self.open, self.inside = {}, None, False
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        told = dict(attrs)
        name = told.get("name")
        if tag == "form":
            self.inside = "_form" in (told.get("id") or "") or told.get("id") == "changelist-form"
        if not self.inside:
            return
        if tag == "input" and name and told.get("type") not in ("submit", "button", "file"):
            self.add(name, told)
        elif tag == "textarea" and name:
            self.open = Control(name, "text", "", longest=int(told.get("maxlength") or 0))
            self.found[name] = self.open
        elif tag == "select" and name:
            self.open = Control(name, "select", [] if "multiple" in told else "")
            self.found[name] = self.open
        elif tag == "option" and self.open is not None and self.open.kind == "select":
            self.option(told.get("value") or "", "selected" in told)

    def option(self, value, chosen):
        if not chosen:
            self.open.options.append(value)
        elif isinstance(self.open.value, list):
            self.open.value.append(value)
        else:
            self.open.value = value

    def add(self, name, told):
        kind, value = told.get("type", "text"), told.get("value") or ""
        if kind in ("checkbox", "radio"):
            if name in self.found and kind == "radio" and "checked" not in told:
                self.found[name].options.append(value)
                return
            value = (value or "on") if "checked" in told else None
        self.found[name] = Control(
            name,
            kind,
            value,
            low=told.get("min", ""),
            high=told.get("max", ""),
            longest=int(told.get("maxlength") or 0),
        )

    def handle_data(self, data):
        if self.open is not None and self.open.kind == "text":
            self.open.value += data.removeprefix("\n") if not self.open.value else data

    def handle_endtag(self, tag):
        if tag in ("textarea", "select"):
            self.open = None
        elif tag == "form":
            self.inside = False


def controls_of(answer):
    """Return the controls of the form on a page of the admin, by name; none where it is only shown."""
    return Controls(answer.content.decode()).found if answer.status_code == 200 else {}


def as_sent(controls, **instead):
    """Return the form's data as a browser posts it."""
    values = {one.name: one.value for one in controls.values()} | instead
    return {name: value for name, value in values.items() if value is not None and "__prefix__" not in name}


def other_values(one):
    """Return what a person could write into a field instead."""
    if one.kind == "hidden" or "__prefix__" in one.name or one.name.startswith("_"):
        return []
    if one.kind == "checkbox":
        return [None if one.value else "on"]
    if one.kind in ("select", "radio"):
        if isinstance(one.value, list):
            return [[], one.options[:MOST_OPTIONS]]
        return one.options[:MOST_OPTIONS]
    if one.kind == "number":
        low, high = one.low or "-1", one.high or "2147483647"
        return sorted({"", low, high, *SENSIBLE.get(one.name, ())} - {one.value})
    if one.name.endswith("_0"):  # a date, and beside it a time
        return [*SENSIBLE.get(one.name, ()), *DATES]
    if one.name.endswith("_1"):
        return list(TIMES)
    texts = (*SENSIBLE.get(one.name, ()), *TEXTS, "w" * (one.longest or 300))
    return [text for text in texts if text != one.value]
