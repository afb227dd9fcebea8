"""Atom feeds: strict XML of what everybody may read, whatever people wrote and whoever asks; and what they cost."""

from datetime import timedelta
from xml.etree import ElementTree

import pytest
from django.test import Client
from hypothesis import given
from hypothesis import strategies as st

from operatorlog.models import Entry, Visibility
from portal.web.feeds import views
from portal.web.feeds.atom import MOST, html_text, xml_text
from portal.web.feeds.following import LASTS, WELL, follow
from portal.web.feeds.models import Downtime
from queueing.models import Turn
from robots.models import Frame, Lease, Robot
from robots.states import Cycle, GrantKind

pytestmark = [pytest.mark.service, pytest.mark.django_db]
SITE, ATOM = "https://robots.example.org", "{http://www.w3.org/2005/Atom}"
HOSTILE = "a\x00\x07b ]]> <script>&amp; \u202e\u05d0\ufffe</content>"
MINUTE = 60


@pytest.fixture(autouse=True)
def site(settings):
    settings.SITE_ADDRESS = SITE


def written(robot, person, now, text="found a watch", **more):
    grant = robot.grants.create(kind=GrantKind.TURN, holder=person, opened_at=now, ended_at=now)
    turn = Turn.objects.create(
        robot=robot, user=person, grant=grant, started_at=now, base_until=now, until=now, last_seen=now, ended_at=now
    )
    return Entry.objects.create(turn=turn, author=person, robot=robot, text=text, written_at=now, **more)


def read(address, client=None):
    """Return the root of a feed, as a strict parser reads it."""
    answer = (client or Client()).get(address)
    assert answer.status_code == 200
    assert answer["Content-Type"] == "application/atom+xml; charset=utf-8"
    assert answer["Cache-Control"] == "public, max-age=300"
    return ElementTree.fromstring(answer.content)


def entries(address, client=None):
    return read(address, client).findall(f"{ATOM}entry")


def of(entry, *names):
    return [entry.findtext(f"{ATOM}{name}") for name in names]


def link(element, kind):
    return next((one for one in element.findall(f"{ATOM}link") if one.get("rel") == kind), None)


def test_an_entry_has_author_text_picture_and_the_page_of_its_turn(robot, people, clock, media):
    (media / "frames").mkdir()
    (media / "frames/a.jpg").write_bytes(b"jpeg!")
    frame = Frame.objects.create(robot=robot, taken_at=clock.now(), file="frames/a.jpg")
    entry = written(robot, people["ada"], clock.now(), "found\n\na watch", frame=frame)
    Entry.objects.update(edited_at=clock.go(MINUTE))
    for address in ("/log.atom", "/robots/mercury/log.atom"):
        root = read(address)
        assert root.get("{http://www.w3.org/XML/1998/namespace}lang") == "en"
        assert of(root, "id") == [f"{SITE}{address}"]
        assert link(root, "self").get("href") == f"{SITE}{address}"
        assert of(root.find(f"{ATOM}author"), "name") == ["Farhand"]
        (one,) = root.findall(f"{ATOM}entry")
        assert of(one, "title", "id") == ["ada on Mercury (simulated)", f"{SITE}/turns/{entry.turn_id}/"]
        assert of(one, "summary") == ["<p>found</p>\n\n<p>a watch</p>"]
        assert of(one, "published", "updated") == ["2026-01-01T00:16:40+00:00", "2026-01-01T00:17:40+00:00"]
        assert of(root, "updated") == of(one, "updated")
        assert of(one.find(f"{ATOM}author"), "name") == ["ada"]
        assert link(one, "alternate").get("href") == f"{SITE}{entry.turn.get_absolute_url()}"
        picture = link(one, "enclosure")
        assert (picture.get("href"), picture.get("length")) == (f"{SITE}/media/frames/a.jpg", "5")
    (media / "frames/a.jpg").unlink()
    assert link(entries("/log.atom")[0], "enclosure") is None


def test_the_feed_of_a_robot_has_its_entries_alone(robot, people, clock):
    other = Robot.objects.create(slug="other", name="Other", driver="mercury", address="sim:mercury")
    for one in (robot, other):
        written(one, people["ada"], clock.go(1))
    assert [of(one, "title") for one in entries("/robots/other/log.atom")] == [["ada on Other (simulated)"]]
    assert len(entries("/log.atom")) == 2
    assert Client().get("/robots/nobody/log.atom").status_code == 404
    assert Client().post("/log.atom").status_code == 405


def test_what_is_hidden_later_is_gone_and_a_reader_that_asks_again_is_told(robot, people, clock):
    entry = written(robot, people["ada"], clock.now())
    author = Client()
    author.force_login(people["ada"])
    before = Client().get("/log.atom")
    same = Client().get("/log.atom", headers={"If-None-Match": before["ETag"]})
    assert (same.status_code, same.content, same["ETag"]) == (304, b"", before["ETag"])
    assert same["Cache-Control"] == before["Cache-Control"]
    Entry.objects.filter(pk=entry.pk).update(visibility=Visibility.HIDDEN)
    for client in (Client(), author):
        assert entries("/log.atom", client) == []
    lately = {"If-None-Match": before["ETag"], "If-Modified-Since": "Thu, 01 Jan 2099 00:00:00 GMT"}
    for headers in (lately, {"If-Modified-Since": lately["If-Modified-Since"]}):
        assert Client().get("/log.atom", headers=headers).status_code == 200
    empty = Client().get("/log.atom")
    assert Client().get("/log.atom", headers={"If-None-Match": empty["ETag"]}).status_code == 304


def test_of_a_deleted_account_nothing_is_left_but_the_text(robot, people, clock):
    before = written(robot, people["ada"], clock.now()).turn_id
    people["ada"].delete()
    (one,) = entries("/log.atom")
    assert of(one, "title", "id") == ["Deleted account on Mercury (simulated)", f"{SITE}/turns/{before}/"]
    assert b"ada" not in Client().get("/log.atom").content.replace(b"metadata", b"")


def test_hostile_texts_are_texts(robot, people, clock):
    Entry.objects.update_or_create(
        pk=written(robot, people["ada"], clock.now()).pk, defaults={"text": HOSTILE.replace("\x00", "\x01")}
    )
    Robot.objects.update(name="M]]>\x08<b>")
    Downtime.objects.create(
        robot=robot,
        label="Faulty",
        reason=HOSTILE.replace("\x00", "\x01"),
        began_at=clock.now(),
        changed_at=clock.now(),
    )
    (one,) = entries("/log.atom")
    assert of(one, "title") == ["ada on M]]>\ufffd<b> (simulated)"]
    assert "&lt;script&gt;&amp;amp;" in one.findtext(f"{ATOM}summary")
    (one,) = entries("/robots/mercury/status.atom")
    assert "]]&gt;" in one.findtext(f"{ATOM}summary")


@given(st.text())
def test_any_text_is_xml_and_has_no_element_of_its_author(text):
    feed = views.LogFeed().feed_type("t", "https://a.example/", "d")
    feed.add_item(xml_text(text), "https://a.example/1", html_text(text))
    root = ElementTree.fromstring(feed.writeString("utf-8").encode("utf-8", "surrogatepass"))
    shown = root.find(f"{ATOM}entry").findtext(f"{ATOM}summary")
    assert "<" not in shown.replace("<p>", "").replace("</p>", "").replace("<br>", "")
    assert root.find(f"{ATOM}entry").findtext(f"{ATOM}title", "") == xml_text(text).replace("\r\n", "\n").replace(
        "\r", "\n"
    )


def test_many_entries_are_cut_and_cost_no_more_queries(robot, people, clock, django_assert_num_queries):
    written(robot, people["ada"], clock.now())
    follow(clock.now())
    with django_assert_num_queries(1):
        entries("/log.atom")
    for n in range(MOST + 5):
        written(robot, people["ada"], clock.go(1))
        Downtime.objects.create(
            robot=robot, label="Offline", began_at=clock.now(), changed_at=clock.now(), ended_at=clock.go(1 + n)
        )
    with django_assert_num_queries(1):
        assert len(entries("/log.atom")) == MOST
    with django_assert_num_queries(1):
        assert len(entries("/status.atom")) == MOST


def test_addresses_are_of_the_site_whatever_the_request_says(robot, people, clock):
    written(robot, people["ada"], clock.now())
    answer = Client().get("/log.atom", headers={"X-Forwarded-Host": "evil.example"}).content.decode()
    assert "evil.example" not in answer
    assert "testserver" not in answer
    assert answer == Client(headers={"accept-language": "de"}).get("/log.atom").content.decode()


def test_pages_say_where_their_feed_is(robot, people, clock, client):
    log = client.get("/log/").content.decode()
    assert 'type="application/atom+xml" title="Operator\'s log" href="/log.atom">' in log.split("</head>")[0]
    assert "This log as an Atom feed" in log.split("</head>")[1]
    of_robot = client.get("/log/?robot=mercury").content.decode()
    assert of_robot.count('"/robots/mercury/log.atom"') == 2
    assert client.get("/log/", {"robot": 'no such "one"'}).status_code == 200
    status = client.get("/status/").content.decode()
    assert status.count('"/status.atom"') == 2
    page = client.get("/robots/mercury/").content.decode().split("</head>")[0]
    for address in ("/robots/mercury/log.atom", "/robots/mercury/status.atom"):
        assert f'href="{address}"' in page
        assert client.get(address).status_code == 200


@pytest.fixture
def served(robot, clock, monkeypatch):
    """A robot in service, by the tests' clock."""
    monkeypatch.setattr(views, "SYSTEM", clock)
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": clock.now() + timedelta(days=99)})
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.READY, enabled=True)
    return robot


def rounds(clock, minutes):
    for _ in range(int(minutes)):
        follow(clock.now())
        clock.go(MINUTE)


def test_a_time_out_of_service_is_one_item_that_is_updated_at_its_end(served, clock):
    rounds(clock, 2)
    assert entries("/status.atom") == []
    Robot.objects.update(cycle=Cycle.LOCKED_OUT, lockout_note="Kim exchanges a belt.")
    rounds(clock, 4)
    (one,) = entries("/robots/mercury/status.atom")
    first = of(one, "id", "published", "updated")
    assert of(one, "title") == ["Mercury (simulated): Locked out"]
    assert of(one, "summary") == ["<p>Locked out since 2026-01-01 00:18 UTC. Staff write: “Kim exchanges a belt.”</p>"]
    assert link(one, "alternate").get("href") == f"{SITE}/robots/mercury/"
    assert "Kim exchanges a belt." in Client().get("/status/").content.decode()
    Robot.objects.update(lockout_note="Kim waits for a belt.")
    rounds(clock, 1)
    (one,) = entries("/status.atom")
    assert "waits for a belt" in one.findtext(f"{ATOM}summary")
    assert of(one, "id", "published") == first[:2]
    assert of(one, "updated") > first[2:]
    Robot.objects.update(cycle=Cycle.READY, lockout_note="")
    rounds(clock, 1)
    (one,) = entries("/status.atom")
    assert of(one, "title", "id") == ["Mercury (simulated): in service again", first[0]]
    assert of(one, "summary") == ["<p>Locked out from 2026-01-01 00:18 UTC to 2026-01-01 00:23 UTC.</p>"]
    assert "belt" not in str(list(Downtime.objects.values())), "no page tells a reason that is over"


def test_a_moment_out_of_service_is_told_to_nobody_and_one_that_comes_back_is_one_item(served, clock):
    Robot.objects.update(stop_latched=True)
    rounds(clock, 1)
    assert entries("/status.atom") == []
    Robot.objects.update(stop_latched=False)
    rounds(clock, 3)
    assert not Downtime.objects.exists()
    for _ in range(6):
        Lease.objects.update(expires_at=clock.now())
        rounds(clock, LASTS.total_seconds() / MINUTE + 1)
        Lease.objects.update(expires_at=clock.now() + timedelta(days=1))
        rounds(clock, WELL.total_seconds() / MINUTE - 2)
    assert [of(one, "title") for one in entries("/status.atom")] == [["Mercury (simulated): in service again"]]
    Lease.objects.update(expires_at=clock.now() + timedelta(days=999))
    follow(clock.go(500 * 86_400))
    assert not Downtime.objects.exists(), "400 days later nobody asks"


def test_a_robot_that_was_never_switched_on_is_not_told_of(robot, clock):
    Robot.objects.create(slug="new", name="New", driver="mercury", address="sim:mercury")
    Lease.objects.create(robot=robot, epoch=1)
    Robot.objects.update(enabled=False, reason="The arm does not answer.")  # as its worker wrote before
    rounds(clock, 4)
    assert [one.robot.slug for one in Downtime.objects.all()] == ["mercury"]
    said = Downtime.objects.get()
    assert (said.label, said.reason) == ("Switched off", "Staff have switched this robot off.")


def test_what_staff_alone_know_is_in_no_feed(served, clock):
    from robots.services.incidents import incident

    incident(served, "silent", "A driver failed at 10.0.0.7.", clock.now(), remedy="Restarted.")
    rounds(clock, 9)
    assert entries("/status.atom") == []
