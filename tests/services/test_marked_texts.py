"""Every text of the pages is marked for translation: in the pseudo-language, no word of them is left in English."""

import asyncio
import re
from html import unescape

import pytest
from django.http import Http404
from django.test import Client, RequestFactory
from django.utils.translation import get_language

from operatorlog.models import Round
from portal.edge.requests import Bounded
from portal.web.pages import errors
from queueing import services as queue
from queueing.models import Ticket
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.services.lockout import lock_out
from tests.services.browsers import signed_in
from tests.services.marked import PSEUDO, TURNED, WORD, Texts

pytestmark = [pytest.mark.service, pytest.mark.django_db]
# names of people, robots, formats and languages, words that people wrote, and units
DATA = re.compile(
    r"\b(Farhand|Far|hand|English|Deutsch|Pseudo|Mercury|Shuttle|Arm|Ratt?|Spare|ada|bob|eve|root"
    r"|I found a watch|min|UTC|JSON|CSV|JPEG|GB|MB|kbit|GET|HEAD|POST|OPTIONS|DELETE|ALLOWED_HOSTS)\b"
)


def unmarked(answer):
    """Return the texts of a page in which an English word is left."""
    texts = [" ".join(text.split()) for text in Texts(answer.text).found]
    return [text for text in texts if WORD.search(DATA.sub("", TURNED.sub("", text)))]


SITE = [
    "/", "/story/", "/status/", "/statistics/", "/statistics/?days=7", "/statistics/?robot=irat&days=90", "/nowhere/",
    "/robots/irat/statistics/", "/robots/irat/statistics/?from=soon", "/embed/robots/mercury/",
]  # fmt: skip


@pytest.mark.parametrize("role", ["", "ada", "bob", "eve", "root"])  # who drives, has ended, waits, is staff
def test_no_text_of_a_page_of_the_site_is_left_in_english(used, role):
    browser = signed_in(used.get(role), headers={"accept-language": PSEUDO})
    left = {path: unmarked(browser.get(path)) for path in [*SITE, *(["/me/"] if role else [])]}
    assert {path: texts for path, texts in left.items() if texts} == {}


def test_no_text_of_the_bar_of_places_is_left_in_english(robot, people, owned):
    browser = signed_in(people["ada"], headers={"accept-language": PSEUDO})
    queue.join(robot, people["ada"], SYSTEM.now())
    states = []
    for change in (
        lambda: None,
        lambda: queue.tick(SYSTEM.now()),
        lambda: queue.accept(robot, people["ada"], SYSTEM.now()),
    ):
        change()
        answer = browser.get("/story/")
        states += [Ticket.objects.get().state]
        assert 'name="ticket"' in answer.text
        assert unmarked(answer) == []
    assert states == ["waiting", "offered", "operating"]


@pytest.mark.parametrize("draw", [
    lambda request: errors.unknown_host(request), lambda request: errors.not_allowed(request, ["GET", "POST"]),
    lambda request: errors.bad_request(request, ValueError()), lambda request: errors.not_found(request, Http404()),
    lambda request: errors.forbidden(request, PermissionError()), errors.csrf_failure, errors.too_many,
    errors.server_error, lambda request: errors.software_missing(request, "Mercury"),
])  # fmt: skip
def test_an_error_before_any_middleware_is_in_the_language_of_the_request(robot, draw):
    before = get_language()
    answer = draw(RequestFactory().get("/", headers={"accept-language": PSEUDO}))
    assert 'dir="rtl"' in answer.text
    assert unmarked(answer) == []
    assert get_language() == before


def test_a_refusal_at_the_door_is_in_the_language_of_the_browser():
    sent = []

    async def send(message):
        sent.append(message)

    headers = [(b"content-length", b"9" * 12), (b"accept-language", b"fr, de;q=0.5")]
    asyncio.run(
        Bounded(None)({"type": "http", "path": "/", "client": ("192.0.2.1", 1), "headers": headers}, None, send)
    )
    assert sent[0]["status"] == 413
    assert sent[1]["body"].decode() == "Die Anfrage ist zu groß.\n"


def test_what_other_software_reads_is_english(used, monkeypatch):
    now = SYSTEM.now()
    monkeypatch.setattr(type(SYSTEM), "now", lambda _: now)  # the same moment for both
    german = {"accept-language": "de"}
    for path in ("/statistics.json", "/statistics.csv", "/robots/irat/statistics.json", "/statistics.json?days=7", "/log.atom",
                 "/robots/mercury/status.atom"):  # fmt: skip
        assert Client(headers=german).get(path).content == Client().get(path).content
    assert "Seitenaufrufe" in Client(headers=german).get("/statistics/").text


WRITTEN = ("A new belt", "Free now. See 3 right")  # both fit texts of the portal with placeholders


@pytest.mark.parametrize("note", WRITTEN)
def test_the_note_of_staff_is_shown_as_they_wrote_it(robot, people, client, note):
    lock_out(robot, people["kim"], note)
    for path in ("/status/", "/robots/mercury/", "/embed/robots/mercury/", "/classic/mercury/"):
        page = unescape(client.get(path, follow=True, headers={"accept-language": "de"}).text)
        assert f"Das Personal schreibt: „{note}“" in page, path
    client.force_login(people["kim"])
    for path in ("/admin/", f"/admin/robots/robot/{robot.pk}/change/"):
        page = unescape(client.get(path, headers={"accept-language": "de"}).text)
        assert f"Das Personal schreibt: „{note}“" in page, path


@pytest.mark.parametrize("words", WRITTEN)
def test_so_are_a_puzzle_and_a_tagline_that_staff_wrote(robot, client, words):
    Robot.objects.filter(pk=robot.pk).update(tagline=words)
    Round.objects.create(robot=robot, number=1, began_at=SYSTEM.now(), puzzle=words)
    for path in ("/", "/robots/mercury/", "/robots/mercury/finds/", "/story/"):
        assert words in unescape(client.get(path, headers={"accept-language": "de"}).text), path


def test_hours_of_statistics_are_those_of_the_reader(shuttle, client):
    at = {"from": "2026-11-01T10:00"}
    client.cookies["zone"] = "Asia/Kolkata"
    page = client.get("/robots/mercury/statistics/", at).text
    assert '<input id="from" name="from" type="datetime-local" value="2026-11-01T15:30">' in page
    assert '<th scope="row">15:30</th>' in page
    same = client.get("/robots/mercury/statistics/", {"from": "2026-11-01T15:30", "zone": "Asia/Kolkata"}).text
    assert "?from=2026-11-01T10:00" in page and "?from=2026-11-01T10:00" in same
    client.cookies["zone"] = ""
    assert "10:00 UTC</time>" in client.get("/robots/mercury/statistics/", at).text
    assert "Hour from (UTC)" in client.get("/robots/mercury/statistics/", at | {"zone": "../etc"}).text


def test_numbers_and_days_of_the_daily_figures_are_written_as_the_language_has_them(used):
    page = Client(headers={"accept-language": "de"}).get("/robots/irat/statistics/").text
    assert "100,0 %" in page
    assert not re.search(r'(x|y|width|height|x1|y1)="\d+,', page)
