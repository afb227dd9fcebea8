"""Each page of the portal is in the list of those of which pictures are made and at which axe looks."""

from django.urls import URLPattern, get_resolver, resolve

from tests.e2e.pages import OWN, PUBLIC, STAFF, known

ROWS = {
    "turn": 1,
    "job": "a",
    "recording": "a",
    "robot": 1,
    "new": "puma",
    "practice": "twin",
    "reset": "1-a",
    "confirmation": "a",
}
# read by software or part of a page; only sent to; not in use here: its people have passwords, and get no codes
NO_PAGES = {
    "daily-json", "daily-csv", "statistics-json", "survey-csv", "texts", "alerts", "choices", "places", "stream-code", "programs", "model", "dug",
    "orientation-picture", "composite", "camera", "snapshot", "shot", "recording-file", "recording-index", "recording-part",
    "recording-picture", "classic-picture", "oembed", "media", "livez", "readyz", "log-feed", "status-feed",
    "robot-log-feed", "robot-status-feed", "push", "push-worker",
    "language", "drive", "practise", "ask-lapse", "ask-movie",
    "account_set_password", "send-again", "account_confirm_login_code",
}  # fmt: skip
REACHED_BY = {"classic-page": "classic"}  # redirects to it


def names(patterns):
    """Yield the names of all addresses outside the admin."""
    for one in patterns:
        if isinstance(one, URLPattern):
            yield one.name
        elif one.app_name != "admin":
            yield from names(one.url_patterns)


def test_every_page_is_in_the_list():
    listed = {
        resolve(address).url_name for address in known(PUBLIC | OWN | STAFF, **ROWS).values() if address != "/nothing/"
    }
    all_of_them = {name for name in names(get_resolver().url_patterns) if name}
    assert NO_PAGES - all_of_them == set()
    assert {REACHED_BY.get(name, name) for name in all_of_them - NO_PAGES} - listed == set()
