"""The pages of jobs: without scripts, for people and guests; public fields, and permission to cancel."""

import re
from dataclasses import replace

import pytest
from django.conf import settings
from django.core import mail
from django.test import Client
from django.utils.html import escape

from queueing import services as queue
from queueing.models import Job
from queueing.services import Asker, ask
from robots.kit.clock import SYSTEM
from robots.models import Command
from tests.services.browsers import signed_in
from tests.services.test_jobs import settle

pytestmark = pytest.mark.django_db


def post(client, x="1.0", **more):
    return client.post("/robots/mercury/jobs/", {"kind": "go", "arg-x": x, **more})


@pytest.mark.service
def test_a_guest_asks_and_finds_the_job_again(shuttle, clock):
    guest, other = Client(), Client()
    assert b"Ask for it" in guest.get("/robots/mercury/jobs/").content
    job = Job.objects.get(key=post(guest)["Location"].split("/")[2])
    assert (job.user, len(job.guest), job.account.network, job.args) == (None, 64, "127.0.0.1", {"x": 1.0})
    cookie = guest.cookies["farhand_guest"]
    assert cookie["httponly"]
    assert job.guest not in cookie.value
    page = guest.get(job.get_absolute_url())
    assert page["X-Robots-Tag"] == "noindex, nofollow"
    assert b"Cancel this job" in page.content
    assert b"noindex" in page.content
    assert b"<li>x: <span>1 m</span></li>" in page.content
    assert b"Cancel this job" not in other.get(job.get_absolute_url()).content
    assert job.key not in other.get("/robots/mercury/jobs/").content.decode(), "the address of a guest's page is theirs"
    other.post(job.get_absolute_url())
    job.refresh_from_db()
    assert job.state == "waiting"
    assert post(guest).status_code == 429, "one open job a cookie"
    guest.post(job.get_absolute_url())
    job.refresh_from_db()
    assert job.state == "cancelled"


@pytest.mark.service
def test_what_somebody_wrote_is_for_its_asker_and_staff_alone(shuttle, people, clock):
    ada, reader, staff = signed_in(people["ada"]), signed_in(people["eve"]), signed_in(people["kim"])
    job = ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now())
    Job.objects.filter(pk=job.pk).update(args={"x": 1.0, "note": "for my aunt"})
    for client, seen in ((ada, True), (staff, True), (reader, False), (Client(), False)):
        page = client.get(job.get_absolute_url()).content
        assert b"<li>x: <span>1 m</span></li>" in page
        assert (b"for my aunt" in page) is seen


@pytest.mark.service
def test_the_page_lists_jobs_in_the_order_in_which_they_are_served(shuttle, clock, monkeypatch):
    first, other = (Asker(guest=name * 64, network=f"192.0.2.{n}") for n, name in enumerate("ab"))
    asked = [ask(shuttle, who, "go", {"x": 1.0}, clock.now()).pk for who in (first, replace(first, guest="c"), other)]
    queue.tick(clock.now())
    running, behind, beside = asked
    page = Client().get("/robots/mercury/jobs/")
    assert [job.pk for job in page.context["jobs"]] == [running, beside, behind]
    monkeypatch.setattr("portal.web.jobs.views.SHOWN", 1)
    page = Client().get("/robots/mercury/jobs/")
    assert [job.state for job in page.context["jobs"]] == ["running"], "the one under way is never cut off"


@pytest.mark.service
def test_a_job_behind_anothers_of_its_network_calls_nothing_the_readers_own(shuttle, people, clock):
    guest, other, ada = Client(), Client(), signed_in(people["ada"])
    for client in (guest, other, ada, ada):
        post(client)
    queue.tick(clock.now())
    found = Job.objects.order_by("id")
    words = [Client().get(job.get_absolute_url()).content.decode() for job in found]
    assert "2 before it, among them an earlier request from the same network address." in words[1]
    assert "1 before it." in words[2]
    assert "3 before it, among them an earlier request of the same person." in words[3]


@pytest.mark.service
@pytest.mark.asvs("2.4.1")
def test_who_asks_and_cancels_again_and_again_is_refused_for_a_while(shuttle, people, settings):
    settings.RATE_LIMITS = {"ask": "2/5m/key"}
    guest, kim = Client(), signed_in(people["kim"])
    for client in (guest, kim):
        for _ in range(2):
            client.post(post(client)["Location"])
    for client, words in ((guest, "Your network asks"), (kim, "You ask")):
        page = post(client)
        assert (page.status_code, page["Retry-After"]) == (429, "300")
        assert f"{words} for jobs too often" in page.content.decode()
        told = client.post(
            "/robots/mercury/jobs/", {"kind": "go", "arg-x": "1.0"}, headers={"accept": "application/json"}
        )
        assert (told.status_code, told["Retry-After"]) == (429, "300")
        assert told.json()["error"].startswith(words)
    assert post(Client()).status_code == 429, "a fresh cookie is no other network"
    assert Job.objects.count() == 4
    beside = Client(REMOTE_ADDR="192.0.2.9")
    assert post(beside).status_code == 302
    assert kim.post("/robots/mercury/jobs/", {"do": "resume"}).status_code == 302


@pytest.mark.service
@pytest.mark.asvs("8.2.2")
def test_a_forged_cookie_is_nobody(shuttle):
    guest, thief = Client(), Client()
    job = Job.objects.get(key=post(guest)["Location"].split("/")[2])
    thief.cookies["farhand_guest"] = guest.cookies["farhand_guest"].value[:-3] + "abc"
    thief.post(job.get_absolute_url())
    job.refresh_from_db()
    assert job.state == "waiting"


@pytest.mark.service
@pytest.mark.parametrize("x", ["", "nan", "inf", "1e308", "-1", "two"])
def test_a_wrong_value_is_refused_in_words(shuttle, x):
    answer = post(Client(), x, **{"arg-rail": "2"})
    assert (answer.status_code, Job.objects.count()) == (400, 0)
    page = answer.content.decode()
    assert re.search(r'role="alert">[^<]*x[^<]*\.</p>', page)
    assert f'name="arg-x" value="{x}"' in page, "what was written is not lost"
    assert 'name="arg-rail" value="2"' in page


@pytest.mark.service
def test_a_fraction_is_refused_where_a_whole_number_is_meant(shuttle):
    answer = post(Client(), **{"arg-rail": "1.5"})
    assert (answer.status_code, Job.objects.count()) == (400, 0)
    assert b"rail must be a whole number." in answer.content
    assert re.search(r'id="go-rail"[^>]*step="1" min="1"', answer.content.decode())


@pytest.mark.service
def test_a_person_is_told_on_every_page_and_by_mail_if_they_asked(
    shuttle, people, clock, django_capture_on_commit_callbacks
):
    ada = signed_in(people["ada"])
    address = post(ada, name="Ada <b>", mail="yes")["Location"]
    assert b"Ada &lt;b&gt;" in Client().get(address).content
    queue.tick(clock.now())
    with django_capture_on_commit_callbacks(execute=True):
        settle(clock)
    assert [m.to for m in mail.outbox] == [["ada@example.org"]]
    assert settings.SITE_ADDRESS + address in mail.outbox[0].body.split()
    job = Job.objects.get()
    assert job.ended_at == clock.now()
    assert b"Your job on" not in ada.get("/story/").content, "months ago"
    Job.objects.update(ended_at=SYSTEM.now())
    assert b"Your job on Mercury (simulated) has ended" in ada.get("/story/").content
    assert b"Your job on" not in Client().get("/story/").content
    assert b"Done" in ada.get(address).content
    assert b"Your job on" not in ada.get("/story/").content


@pytest.mark.service
def test_without_being_asked_no_mail_is_sent(shuttle, people, clock, django_capture_on_commit_callbacks):
    ada = signed_in(people["ada"])
    post(ada)
    queue.tick(clock.now())
    with django_capture_on_commit_callbacks(execute=True):
        settle(clock)
    assert mail.outbox == []


@pytest.mark.service
def test_staff_resume_on_the_page_and_nobody_else(shuttle, people, clock):
    from robots import services

    post(Client())
    services.stop(shuttle, people["kim"])
    services.release_stop(shuttle, people["kim"], True)
    kim, ada = signed_in(people["kim"]), signed_in(people["ada"])
    assert b"Resume jobs</button>" not in ada.get("/robots/mercury/jobs/").content
    assert b"Resume jobs</button>" in kim.get("/robots/mercury/jobs/").content
    assert ada.post("/robots/mercury/jobs/", {"do": "resume"}).status_code == 403
    queue.tick(clock.now())
    assert Command.objects.count() == 0
    kim.post("/robots/mercury/jobs/", {"do": "resume"})
    queue.tick(clock.now())
    assert Command.objects.count() == 1


@pytest.mark.parametrize("name", ["admin (staff)", "Ada [staff]", "s t a f f", "5taff", "ѕtаff", "st\u200baff", "adm\u00adin", "Ada — Operator", "bob", "B0B", "mod", "Mercury", "ＳＴＡＦＦ", "the moderators",
    "admin1", "staff2", "1admin", "admin１", "staff²", "admin٢", "5taff2", "st4ff", "4dm1n7", "ad.min", "S-T-A-F-F_3", "the staff2 of x", "mercury7",
    "@dmin", "adm!n", "@dm!n!", "$taff", "$t@ff", "@admin", "admin!", "adm|n", "adm¡n", "st@ff2", "Ada @dmin!", "$y$t€m"])  # fmt: skip
def test_a_name_on_the_page_is_no_role_and_nobody_else(shuttle, people, name):
    ada = signed_in(people["ada"])
    answer = post(ada, name=name)
    assert answer.status_code == 400
    assert b"may not be that of a role" in answer.content
    assert Job.objects.count() == 0


@pytest.mark.parametrize("name, shown", [
    ("Ada \u202eecila\u202c!", "Ada ecila!"), ("\u2066Ada\u2069\u200f\u061c", "Ada"), ("Ada\r\n\tL.\x1b[2J", "Ada L.[2J"),
    ("\u202e", ""), ("Ada", "Ada"), ("Falstaff", "Falstaff"), ("Family of Ada", "Family of Ada"), ("Ada 2", "Ada 2"), ("42", "42"), ("Ada & Bo!", "Ada & Bo!"), ("$am", "$am"), ("!!", "!!"), ("me@home", "me@home"), ("Zoë & Åsa", "Zoë & Åsa"),
])  # fmt: skip
def test_a_name_on_the_page_turns_no_text_round(shuttle, people, name, shown):
    ada = signed_in(people["ada"])
    assert post(ada, name=name).status_code == 302
    assert Job.objects.get().shown_name == shown


@pytest.mark.service
def test_a_guest_has_no_name_on_the_page(shuttle):
    assert post(Client(), name="admin (staff)").status_code == 302
    assert Job.objects.get().shown_name == ""


@pytest.mark.service
def test_older_names_are_freed_of_what_turns_text_round(shuttle, people):
    from importlib import import_module

    from django.apps import apps

    ada = signed_in(people["ada"])
    post(ada, name="Ada")
    for old, plain in (("\u202eadA", "adA"), ("Ada", "Ada"), ("admin (staff)", ""), ("5taff", "")):
        Job.objects.update(shown_name=old)
        import_module("queueing.migrations.0010_plain_names").clean(apps, None)
        assert Job.objects.get().shown_name == plain


@pytest.mark.service
def test_the_note_of_an_ended_job_is_dismissed_where_one_is(shuttle, people, clock):
    ada, bob = signed_in(people["ada"]), signed_in(people["bob"])
    address = post(ada)["Location"]
    queue.tick(clock.now())
    settle(clock)
    Job.objects.update(ended_at=SYSTEM.now())
    listed = "/log/?robot=mercury&page=1"
    fields = set(re.findall(r'name="next" value="([^"]*)"', ada.get(listed).content.decode()))
    assert fields == {escape(listed)}, "the note's, and the turn bar's"
    assert bob.post(address, {"do": "seen", "next": listed})["Location"] == listed
    seen = {"do": "seen", "next": "/story/"}
    assert bob.post(address, seen)["Location"] == "/story/"
    assert b"Your job on" in ada.get("/story/").content, "nobody else dismisses it"
    for away in ("https://evil.example/", "//evil.example/?page=1"):
        assert ada.post(address, {**seen, "next": away})["Location"] == "/"
    assert b"Your job on" not in ada.get("/story/").content


def test_the_page_says_how_many_open_jobs_it_leaves_out(shuttle, people, clock):
    for number in range(32):
        who = Asker(guest=f"{number:064}", network=f"192.0.2.{number}")
        ask(shuttle, who, "go", {"x": 1.0}, clock.now())
    page = Client().get("/robots/mercury/jobs/").content.decode()
    assert (page.count("<td>Waiting</td>"), "2 more wait" in page) == (30, True)
    Job.objects.filter(pk__in=Job.objects.values("pk")[:2]).delete()
    assert "more wait" not in Client().get("/robots/mercury/jobs/").content.decode()
