"""`/oembed/`: a frame for links of ours that everybody may see; nothing for all others, whatever is asked."""

import html
import re
from urllib.parse import urlencode

import pytest
from django.test import Client
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.django import TestCase

from operatorlog.models import Entry, Visibility
from portal.web.recordings.oembed import HEIGHT, LONGEST, WIDTH
from queueing.models import Turn
from robots.kit.clock import SYSTEM
from robots.models import Robot
from tests.services.test_moments import SITE
from tests.services.test_moments import taken as taken

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("media")]


def asked(url, client=None, **more):
    return (client or Client()).get("/oembed/", {"url": url, **more})


def linked(page):
    """Return the address that a page's head gives, as a path of the site."""
    found = re.search(r'<link rel="alternate" type="application/json\+oembed" href="([^"]+)">', page)
    return html.unescape(found[1]).removeprefix(SITE) if found else ""


def test_a_link_to_a_moment_gives_its_frame_which_begins_there(taken):
    told = asked(f"{SITE}{taken.get_absolute_url()}?t=4", format="json").json()
    source = re.search(r'^<iframe src="([^"]+)" width="640" height="480" title="Turn of ada on Mercury', told["html"])[
        1
    ]
    assert source == f"{SITE}/embed/recordings/{taken.key}/?t=4"
    assert (told["version"], told["type"], told["width"], told["height"]) == ("1.0", "rich", WIDTH, HEIGHT)
    frame = Client().get(source.removeprefix(SITE))
    assert '"at": 4' in frame.content.decode()
    assert "frame-ancestors *" in frame["Content-Security-Policy"]
    for link in (f"{SITE}/embed/recordings/{taken.key}/?t=4", f"{SITE.upper()}{taken.get_absolute_url()}?t=4&x=1#y"):
        assert asked(link).json() == told


def test_a_robot_has_a_frame_while_it_is_switched_on(taken, robot):
    for path in ("/robots/mercury/", "/embed/robots/mercury/"):
        told = asked(f"{SITE}{path}").json()
        assert told["title"] == robot.full_name
        assert f'src="{SITE}/embed/robots/mercury/"' in told["html"]
    Robot.objects.update(enabled=False)
    assert asked(f"{SITE}/robots/mercury/").status_code == 404


def test_pages_say_where_their_frame_is_found(taken, client):
    for path in (f"{taken.get_absolute_url()}?t=4", "/robots/mercury/"):
        page = client.get(path, headers={"X-Forwarded-Host": "evil.example"}).content.decode()
        answer = client.get(linked(page))
        assert answer.status_code == 200
        assert ("?t=4" in answer.json()["html"]) == ("?t=4" in path)
        assert "evil.example" not in page + answer.content.decode()


def test_what_a_moderator_has_hidden_is_as_what_there_is_not_even_for_who_may_see_it(taken, people):
    turn = Turn.objects.get()
    Entry.objects.create(
        turn=turn, author=people["ada"], robot=turn.robot, text="x", written_at=SYSTEM.now(),
        visibility=Visibility.HIDDEN,
    )  # fmt: skip
    operator = Client()
    operator.force_login(people["ada"])
    page = operator.get(taken.get_absolute_url())
    assert page.status_code == 200
    assert not linked(page.content.decode())
    hidden = asked(f"{SITE}{taken.get_absolute_url()}", operator)
    nothing = asked(f"{SITE}/recordings/none/")
    assert (hidden.status_code, hidden.content) == (404, nothing.content)
    assert nothing.status_code == 404


@pytest.mark.parametrize(
    "link",
    [
        "https://evil.example/robots/mercury/", f"{SITE}.evil.example/robots/mercury/",
        f"{SITE}@evil.example/robots/mercury/", "https://a@robots.example.org/robots/mercury/",
        f"{SITE}:8443/robots/mercury/", "//robots.example.org/robots/mercury/", "/robots/mercury/", "robots/mercury/",
        "ftp://robots.example.org/robots/mercury/", "javascript://robots.example.org/robots/mercury/", f"{SITE}/log/",
        f"{SITE}/", f"{SITE}/admin/", f"{SITE}/me/", f"{SITE}/robots/mercury", f"{SITE}/robots/none/",
        f"{SITE}/recordings/%00/", f"{SITE}/recordings/\ud800/", "http://[", "https://[::1/",
        f"{SITE}/robots/mercury/\n", f"{SITE}/recordings/ünder/", f"{SITE}/oembed/?url={SITE}/robots/mercury/",
    ],
)  # fmt: skip
def test_a_link_that_is_none_of_ours_has_no_frame(taken, link):
    query = urlencode({"url": link}, errors="surrogatepass")
    answer = Client().get(f"/oembed/?{query}")
    assert answer.status_code == 404
    assert answer.json() == {"error": "No recording or robot that everybody may see has this link."}
    assert answer["Cache-Control"] == "no-store"


@pytest.mark.parametrize("query", [{}, {"url": ""}, {"url": "x" * (LONGEST + 1)}])
def test_a_request_without_a_link_says_what_to_give(taken, client, query):
    answer = client.get("/oembed/", query)
    assert answer.status_code == 400
    assert answer.json()["error"].startswith("Give a link of this site as url, for example https://")


def test_another_format_is_not_offered(taken, client):
    answer = asked(f"{SITE}/robots/mercury/", format="xml")
    assert (answer.status_code, answer.json()) == (501, {"error": "Only format=json is offered."})


@pytest.mark.parametrize(
    ("most", "width"), [("320", 320), ("1", 1), ("99999", WIDTH), ("0300", 300), ("9" * 60, WIDTH)]
)
def test_a_frame_is_no_larger_than_was_asked(taken, most, width):
    told = asked(f"{SITE}/robots/mercury/", maxwidth=most, maxheight="200").json()
    assert (told["width"], told["height"]) == (width, 200)
    assert f'width="{width}" height="200"' in told["html"]


@pytest.mark.parametrize("size", ["0", "-1", "1.5", "1e9", "wide", "²", "٣", "000"])
def test_a_size_that_is_none_is_refused_with_a_sentence(taken, size):
    for name in ("maxwidth", "maxheight"):
        answer = asked(f"{SITE}/robots/mercury/", **{name: size})
        assert answer.status_code == 400
        assert answer.json() == {"error": f"Give {name} as a whole number of pixels, at least 1."}


def test_a_name_of_the_robot_is_no_markup(taken, robot):
    Robot.objects.update(name='"><script>alert(1)</script>')
    told = asked(f"{SITE}/robots/mercury/").json()
    assert "<script" not in told["html"]
    assert told["html"].count("<") == 2


def test_everybody_is_told_the_same(taken, people):
    one = Client()
    one.force_login(people["ada"])
    link = f"{SITE}{taken.get_absolute_url()}"
    answer = asked(link, one)
    assert answer.content == asked(link).content
    assert not answer.cookies
    assert answer["Cache-Control"] == "public, max-age=300"


class TestWhatever(TestCase):
    @given(st.text(max_size=60), st.text(max_size=9))
    def test_nothing_that_is_asked_breaks_it(self, link, size):
        query = urlencode({"url": link, "maxwidth": size}, errors="surrogatepass")
        assert self.client.get(f"/oembed/?{query}").status_code in (200, 400, 404)
