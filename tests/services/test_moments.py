"""A recording shared from a moment: link, card, picture, and the pages that other sites may frame."""

import re

import pytest
from django.conf import settings as django_settings
from django.test import Client
from django.urls import get_resolver
from hypothesis import given
from hypothesis import strategies as st

from operatorlog.models import Entry, Visibility
from portal.web.recordings.moments import moment_in
from queueing.models import Turn
from robots.kit.clock import SYSTEM
from robots.models import Recording, RecordingState, Robot
from robots.recordings import keeping
from tests.services.tapes import jpeg, tape_of
from tests.services.test_permissions_pages import routes
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("media")]
GREYS = [40 + 20 * n for n in range(10)]
SITE = "https://robots.example.org"


@pytest.fixture
def taken(robot, people, owned, settings):
    """The recording of a turn of ada: ten seconds, each with a picture of another grey."""
    settings.SITE_ADDRESS = SITE
    drive(robot, people["ada"], SYSTEM.now())
    return recorded(Turn.objects.get())


def recorded(turn):
    from datetime import timedelta

    from robots.kit.packets import picture_packet
    from robots.kit.recording.packets import picture_of

    began = SYSTEM.now()
    found = keeping.begin(turn.grant, "here", began)
    with tape_of(found) as (tape, began_ms):
        for n, grey in enumerate(GREYS):
            ms = began_ms + 1000 * n
            tape.put("camera/0", ms * 10**6, picture_of(picture_packet(n, ms, 0, (), jpeg(grey))))
    keeping.finish(found, RecordingState.READY, "", began + timedelta(seconds=len(GREYS)))
    return Recording.objects.get(pk=found.pk)


def picture(client, recording, second):
    return client.get(f"{recording.get_absolute_url()}{recording.version}/moment-{second}.jpg")


def test_the_picture_of_a_moment_is_the_one_that_was_taken_then(taken, client):
    for second in (0, 4, 9):
        answer = picture(client, taken, second)
        assert (answer.status_code, answer["Content-Type"]) == (200, "image/jpeg")
        assert answer.content == jpeg(GREYS[second])
        assert answer["Cache-Control"] == "public, max-age=3600"
    for second in (12, 10**9, 10**300):
        assert picture(client, taken, second).status_code == 404
    assert client.get(f"{taken.get_absolute_url()}99/moment-1.jpg").status_code == 404


def test_the_card_names_the_site_of_the_settings_and_a_picture_that_is_there(taken, client):
    page = client.get(f"{taken.get_absolute_url()}?t=4", headers={"X-Forwarded-Host": "evil.example"}).content.decode()
    tags = dict(re.findall(r'<meta property="(og:[\w:]+)" content="([^"]*)">', page))
    assert tags["og:title"] == "Turn of ada on Mercury (simulated)"
    assert tags["og:url"] == f"{SITE}{taken.get_absolute_url()}?t=4"
    assert client.get(tags["og:image"].removeprefix(SITE)).content == jpeg(GREYS[4])
    assert "evil.example" not in page
    assert f'data-link="{SITE}{taken.get_absolute_url()}"' in page
    assert '"start": 4000' in page


def test_an_unknown_host_gets_no_card(taken, client):
    answer = client.get(taken.get_absolute_url(), headers={"Host": "evil.example"})
    assert answer.status_code == 400
    assert b"og:image" not in answer.content


@pytest.mark.parametrize("text", ["1e308", "nan", "inf", "-1", "-0.1", "99", "soon", "0x4", "1" * 400, "²"])
def test_a_time_that_is_none_opens_at_the_start_and_says_so(taken, client, text):
    for address in (taken.get_absolute_url(), f"/embed/recordings/{taken.key}/"):
        answer = client.get(address, {"t": text})
        assert answer.status_code == 200
        assert "names no time in this recording" in answer.content.decode()
        assert '"start": 0' in answer.content.decode() or '"at": 0' in answer.content.decode()


@given(st.text(max_size=30))
def test_whatever_a_link_says_the_moment_is_in_the_recording(text):
    from datetime import timedelta

    now = SYSTEM.now()
    found = Recording(began_at=now, ended_at=now + timedelta(seconds=90))
    second, said = moment_in(text, found)
    assert 0 <= second <= 90
    assert said == "" or second == 0


def test_a_hidden_recording_has_no_card_no_picture_and_no_frame(taken, client, people):
    turn = Turn.objects.get()
    Entry.objects.create(
        turn=turn, author=people["ada"], robot=turn.robot, text="x", written_at=SYSTEM.now(),
        visibility=Visibility.HIDDEN,
    )  # fmt: skip
    assert picture(client, taken, 1).status_code == 404
    operator = Client()
    operator.force_login(people["ada"])
    page = operator.get(taken.get_absolute_url())
    assert page.status_code == 200
    assert b"og:" not in page.content
    assert b"replay-share" not in page.content
    assert picture(operator, taken, 1)["Cache-Control"] == "private, no-store"
    assert operator.get(f"/embed/recordings/{taken.key}/").status_code == 404, "a frame knows no session"


def frames(answer):
    return "frame-ancestors *" in answer["Content-Security-Policy"]


def test_embedded_pages_use_no_session_and_have_nothing_to_operate(taken, robot, people):
    one = Client()
    one.force_login(people["ada"])
    for address in (f"/embed/recordings/{taken.key}/?t=3", "/embed/robots/mercury/"):
        answer = one.get(address)
        page = answer.content.decode()
        assert answer.status_code == 200
        assert frames(answer)
        assert "X-Frame-Options" not in answer
        assert not answer.cookies
        assert "Cookie" not in answer.get("Vary", "")
        assert answer["Cache-Control"] == "public, max-age=30"
        assert "<form" not in page
        assert "csrf" not in page
        assert "style=" not in page
        assert page == Client().get(address).content.decode(), "everybody is shown the same"
    Robot.objects.update(enabled=False)
    assert one.get("/embed/robots/mercury/").status_code == 404


def test_nothing_else_may_be_framed(taken, people):
    one = Client()
    one.force_login(people["ada"])
    for address in (
        "/",
        "/log/",
        "/robots/mercury/",
        taken.get_absolute_url(),
        "/statistics/",
        "/admin/",
        "/nothing/",
        "/embed/",
    ):
        answer = one.get(address)
        assert "frame-ancestors 'none'" in answer["Content-Security-Policy"], address
        assert answer["X-Frame-Options"] == "DENY", address
    framable = [route for route in routes(get_resolver().url_patterns) if route.startswith("embed/")]
    assert framable == ["embed/recordings/<str:key>/", "embed/robots/<slug:slug>/"]


def test_a_refusal_of_an_embedded_page_may_be_framed_by_nobody(client, db):
    answer = client.get("/embed/recordings/none/")
    assert answer.status_code == 404
    assert not frames(answer)
    assert django_settings.X_FRAME_OPTIONS == "DENY"
