"""Who does not want their name shown while they drive is "somebody" to all but themselves and staff, on every page."""

import json
from urllib.parse import urlencode

import pytest
from django.contrib.auth.models import AnonymousUser
from django.core.exceptions import ValidationError
from django.test import Client
from django.urls import URLPattern, get_resolver, reverse
from django.utils import translation

from accounts import handles
from accounts.models import User
from operatorlog import services as log
from portal.live.snapshot import of_person, snapshot
from portal.web.recordings.day import movie_of_the_day
from queueing import services as queue
from queueing.models import Turn
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.packets import Changed
from robots.models import Command, Frame
from robots.people import SOMEBODY, driver_name, shown_name
from robots.states import CommandState, GrantEnd
from tests.services.browsers import signed_in
from tests.services.test_moments import SITE
from tests.services.test_moments import taken as taken
from tests.services.test_movie_of_the_day import filmed

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("media")]
NAME = "zebediah"
MOVING = {"camera", "composite"}  # pictures without an end
# the pages that say who drives or drove, and the ones that have the titles of recordings
NAMING = {
    "landing", "robot", "turn", "recordings", "recording", "embed-recording", "movie-of-the-day", "oembed", "classic",
    "classic-page",
}  # fmt: skip


@pytest.fixture
def driven(taken, robot, people):
    """The recording of a turn that goes on, of a person who has given a command, chosen as movie of the day."""
    now = SYSTEM.now()
    User.objects.filter(pk=people["ada"].pk).update(username=NAME)
    people["ada"].refresh_from_db()
    Frame.objects.create(robot=robot, grant=taken.grant, taken_at=now, file="frames/a.jpg", width=193, height=164)
    Command.objects.create(
        robot=robot, grant=taken.grant, client_seq=1, issued_by=people["ada"], kind="down", epoch=5, created_at=now,
        deadline=now, state=CommandState.COMPLETED, ended_at=now,
    )  # fmt: skip
    filmed(taken)
    assert movie_of_the_day(now)
    return taken


def choose(person, shown):
    client = signed_in(person)
    return client.post("/me/choices/", {"do": "name", **({"on": "on"} if shown else {})}, follow=True).content.decode()


def routes(patterns):
    """Yield the names and the parameters of all addresses outside the admin."""
    for one in patterns:
        if isinstance(one, URLPattern):
            yield one.name, one.pattern.converters
        elif one.app_name != "admin":
            yield from routes(one.url_patterns)


def pages(recording, client):
    """Return the text of every page at an address of the portal, by the address's name."""
    turn = Turn.objects.get()
    values = {
        "slug": "mercury", "pk": turn.pk, "key": recording.key, "version": recording.version, "number": 0, "second": 4,
        "at_ms": 0, "day": "2026-11-23", "name": "wide", "look": "wide-light", "language": "de", "token": "x",
        "path": "a.jpg", "kind": "mp4",
    }  # fmt: skip
    found = {}
    for name, parameters in routes(get_resolver().url_patterns):
        if name is None or name in MOVING or name.startswith("account_"):
            continue
        version = {"version": "x"} if name == "texts" else {}
        address = reverse(name, kwargs={key: (values | version)[key] for key in parameters})
        answer = client.get(address, follow=True)
        text = b"".join(answer.streaming_content) if answer.streaming else answer.content
        found[name] = text.decode(errors="replace")
    link = SITE + recording.get_absolute_url()
    return found | {"oembed": client.get(f"/oembed/?{urlencode({'url': link})}").content.decode()}


def with_name(recording, client):
    return {name for name, text in pages(recording, client).items() if NAME in text}


def test_no_page_has_the_name_and_each_that_had_it_says_somebody(driven, people):
    assert with_name(driven, Client()) == NAMING
    choose(people["ada"], shown=False)
    for client in (Client(), signed_in(people["eve"])):
        shown = pages(driven, client)
        assert {name for name, text in shown.items() if NAME in text} == set()
        assert {name for name, text in shown.items() if SOMEBODY in text} >= NAMING
    assert "somebody drives" in Client().get("/").content.decode()


def test_staff_and_the_person_read_it(driven, people):
    choose(people["ada"], shown=False)
    everybodys = {"embed-recording", "oembed"}  # the same for whoever asks
    listed = {"movie-of-the-day"}
    for name in ("ada", "mod", "kim"):
        assert with_name(driven, signed_in(people[name])) >= NAMING - everybodys - listed, name


def told(viewer):
    return snapshot("mercury", viewer, SYSTEM.now(), True)


def test_the_socket_tells_the_name_to_staff_and_the_person_alone(driven, people):
    assert told(AnonymousUser())["operator"] == NAME
    choose(people["ada"], shown=False)
    for viewer in (AnonymousUser(), people["eve"]):
        whole = told(viewer)
        assert NAME not in json.dumps(whole)
        assert (whole["operator"], [one["by"] for one in whole["commands"]]) == (SOMEBODY, [SOMEBODY])
    for name in ("ada", "mod", "kim"):
        whole = told(people[name])
        assert (whole["operator"], [one["by"] for one in whole["commands"]]) == (NAME, [NAME])
        assert of_person("mercury", people[name], SYSTEM.now()) is None, "not the part that is read for many at once"
    assert of_person("mercury", people["eve"], SYSTEM.now()) is not None


def test_pages_that_are_open_read_the_choice_at_once(driven, people, monkeypatch):
    heard = []
    monkeypatch.setattr(bus, "publish_on_commit", lambda slug, event: heard.append((slug, event)))
    choose(people["eve"], shown=False)
    assert heard == []
    choose(people["ada"], shown=False)
    assert heard == [("mercury", Changed("operator"))]


def test_what_a_person_publishes_keeps_the_name(driven, people):
    choose(people["ada"], shown=False)
    turn = Turn.objects.get()
    queue.end_turn(turn, GrantEnd.HOLDER, "ended by the operator", SYSTEM.now())
    turn.refresh_from_db()
    log.write(turn, people["ada"], "A watch.", None, SYSTEM.now())
    found = with_name(driven, Client())
    assert {"log", "log-feed", "landing"} <= found
    assert found <= {"log", "log-feed", "robot-log-feed", "landing", "robot", "turn", "classic", "classic-page"}
    title = Client().get(turn.get_absolute_url()).content.decode().partition("<h1>")[2].partition("</h1>")[0]
    assert title.startswith("somebody on Mercury")


def test_the_choice_is_on_the_persons_page_and_no_one_elses(driven, people):
    box = 'name="on" aria-describedby="name-hint"'
    assert f"{box} checked" in signed_in(people["ada"]).get("/me/").content.decode()
    for _ in range(2):
        page = choose(people["ada"], shown=False)
        assert "Your name is shown to staff alone." in page
        assert f"{box}>" in page
    assert list(User.objects.filter(name_shown=False)) == [people["ada"]]
    assert "Your name is shown." in choose(people["ada"], shown=True)
    assert not User.objects.filter(name_shown=False).exists()
    strict = Client(enforce_csrf_checks=True)
    strict.force_login(people["ada"])
    assert strict.post("/me/choices/", {"do": "name"}).status_code == 403
    assert User.objects.get(username=NAME).name_shown


def test_the_word_is_in_the_readers_language_and_nobodys_handle(people):
    people["ada"].name_shown = False
    assert driver_name(people["ada"], people["eve"]) == SOMEBODY
    assert driver_name(None) == "Deleted account"
    with translation.override("de"):
        assert shown_name(SOMEBODY) != "Deleted account"
    for taken_name in ("somebody", "S0mebody"):
        with pytest.raises(ValidationError):
            handles.validate(taken_name)
