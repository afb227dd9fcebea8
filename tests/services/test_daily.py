"""Daily figures from requests and rows to the page, JSON and CSV; Redis counts addresses, and may be away."""

import asyncio
import csv
import json
from datetime import timedelta

import pytest
from django.contrib.auth.models import Permission
from django.test import Client

from operatorlog.finds import decide
from operatorlog.models import Find, Piece, Round
from portal.web.daily import hits as counting
from portal.web.daily.figures import keep
from portal.web.daily.hits import ALL, CountedPages, Hits, store
from portal.web.daily.models import DailyFigures
from queueing.models import Ticket, Turn
from queueing.services import queue_of
from robots import bus
from robots.bus import web_uptime
from robots.kit.clock import SYSTEM
from robots.models import Command, Robot, Usage
from robots.services.incidents import incident
from robots.services.outages import CODE as OUTAGE
from robots.states import GrantKind

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def today(clock, monkeypatch):
    """The day of the tests' clock; views and counters ask it."""
    for module in ("views", "hits"):
        monkeypatch.setattr(f"portal.web.daily.{module}.SYSTEM", clock)
    return clock.now().date()


@pytest.fixture
def counted(redis_server, monkeypatch):
    """A real day, for Redis lets keys expire by the real time."""
    bus.connection().flushdb()
    return SYSTEM.now().date()


def of(day, robot=None):
    return DailyFigures.objects.get(day=day, robot=robot)


def visits(hits, day, slug, addresses):
    for address in addresses:
        hits.note(day, slug, address)


def test_hits_and_addresses_reach_the_rows_of_robot_and_portal(robot, counted):
    hits = Hits()
    visits(hits, counted, "mercury", [f"192.0.2.{n % 50}" for n in range(200)])
    visits(hits, counted, ALL, ["198.51.100.1", "192.0.2.1"])
    visits(hits, counted, "no-such-robot", ["198.51.100.2"])
    store(hits)
    assert hits.empty()
    assert (of(counted).hits, of(counted, robot).hits) == (203, 200)
    assert of(counted, robot).addresses == pytest.approx(50, abs=2)
    assert of(counted).addresses == pytest.approx(52, abs=2)
    visits(hits, counted, "mercury", ["192.0.2.1"])
    store(hits)
    assert (of(counted, robot).hits, of(counted, robot).addresses) == (201, pytest.approx(50, abs=2))
    assert of(counted).addresses_whole


def test_no_address_is_in_redis_and_all_ends_with_the_day(counted, robot):
    hits = Hits()
    visits(hits, counted, "mercury", ["203.0.113.77"])
    store(hits)
    keys = bus.connection().keys("farhand:visitors:*")
    assert len(keys) == 3, "salt, portal, robot"
    for key in keys:
        assert b"203.0.113" not in bus.connection().dump(key)
        assert 0 < bus.connection().ttl(key) <= 25 * 3600
    assert not any("203.0.113" in str(value) for row in DailyFigures.objects.values() for value in row.values())


def test_two_processes_count_one_address_once_and_other_days_use_other_hashes(counted, robot):
    for _ in range(2):
        process = Hits()
        visits(process, counted, ALL, ["203.0.113.77"])
        store(process)
    assert (of(counted).hits, of(counted).addresses) == (2, 1)
    tomorrow = counted + timedelta(days=1)
    bus.count_addresses(tomorrow, {bus.PORTAL: ["203.0.113.77"]}, SYSTEM.now())
    salts = [bus.connection().get(bus.visitors_key(day, "salt")) for day in (counted, tomorrow)]
    assert salts[0] != salts[1]


def test_a_dead_redis_loses_nothing(robot, counted, monkeypatch):
    hits = Hits()
    visits(hits, counted, ALL, ["192.0.2.1", "192.0.2.2"])
    with monkeypatch.context() as away:
        away.setattr(bus.store, "connection", dead)
        store(hits)
    assert (of(counted).hits, of(counted).addresses) == (2, None), "not known is not zero"
    store(hits)
    assert (of(counted).hits, of(counted).addresses, of(counted).addresses_whole) == (2, 2, True)


def dead():
    raise ConnectionError("away")


def test_a_redis_that_forgot_leaves_a_lower_bound(robot, counted, client):
    hits = Hits()
    visits(hits, counted, ALL, [f"192.0.2.{n}" for n in range(9)])
    store(hits)
    bus.connection().flushdb()
    visits(hits, counted, ALL, ["198.51.100.1"])
    store(hits)
    assert (of(counted).addresses, of(counted).addresses_whole) == (9, False)
    assert b"at least 9" in client.get("/statistics/").content
    assert client.get("/statistics.json").json()["days"][-1]["addresses_complete"] is False


def test_addresses_of_a_day_that_is_long_over_are_said_to_be_missing(robot, counted):
    hits, long_ago = Hits(), counted - timedelta(days=3)
    visits(hits, long_ago, ALL, ["192.0.2.1"])
    store(hits)
    assert (of(long_ago).hits, of(long_ago).addresses, of(long_ago).addresses_whole) == (1, None, False)
    assert hits.empty()


async def page(scope, receive, send):
    kind = b"application/json" if scope["path"].endswith("json") else b"text/html; charset=utf-8"
    status = 404 if "none" in scope["path"] else 200
    await send({"type": "http.response.start", "status": status, "headers": [(b"Content-Type", kind)]})
    await send({"type": "http.response.body", "body": b""})


def test_only_pages_that_were_shown_count(monkeypatch):
    monkeypatch.setattr(counting, "EVERY_S", 3600.0)
    app = CountedPages(page)

    async def visit():
        sent = []
        for path in ("/robots/mercury/", "/statistics.json", "/none/", "/"):
            scope = {
                "type": "http", "method": "GET", "path": path, "client": ("192.0.2.7", 4),
                "headers": [(b"user-agent", b"Mozilla/5.0 Firefox/140.0"), (b"x-forwarded-for", b"203.0.113.9")],
            }  # fmt: skip

            async def send(message):
                sent.append(message["type"])

            await app(scope, None, send)
        app._task.cancel()
        return sent

    assert len(asyncio.run(visit())) == 8
    (counts,) = app.hits.take().values()
    assert dict(counts.hits) == {ALL: 2, "mercury": 1}
    assert counts.addresses[ALL] == {"192.0.2.7"}, "the address of the connection, whatever a header claims"


def driven(robot, person, now):
    """A turn that begins now."""
    grant = robot.grants.create(kind=GrantKind.TURN, holder=person, opened_at=now, ended_at=now)
    return Turn.objects.create(
        robot=robot, user=person, grant=grant, started_at=now, base_until=now, until=now, last_seen=now, ended_at=now
    )


def command(robot, grant, now, **values):
    return Command.objects.create(
        robot=robot, grant=grant, client_seq=Command.objects.count(), kind="move", epoch=5, created_at=now,
        deadline=now, ended_at=now, **{"state": "completed", "accepted_at": now} | values,
    )  # fmt: skip


def test_turns_commands_and_use_follow_from_their_rows(robot, people, clock, today):
    turn = driven(robot, people["ada"], clock.now())
    command(robot, turn.grant, clock.now())
    ours = robot.grants.create(kind=GrantKind.HANDOVER, opened_at=clock.now(), ended_at=clock.now())
    command(robot, ours, clock.now())
    Usage.objects.create(robot=robot, at=clock.now(), online_s=300.0, watching=4, sent_bytes=5_000_000_000)
    keep(clock.now())
    for row in (of(today), of(today, robot)):
        assert (row.turns, row.commands, row.entries) == (1, 1, 0), "what the portal does by itself is left out"
        assert (row.online_s, row.watching, row.sent_bytes) == (300.0, 4, 5_000_000_000)
        assert (row.hits, row.addresses) == (None, None)
    keep(clock.now())
    assert DailyFigures.objects.count() == 2


def test_days_before_are_computed_once_and_what_was_deleted_since_stays_counted(robot, people, clock, today):
    turn = driven(robot, people["ada"], clock.now())
    command(robot, turn.grant, clock.now())
    clock.go(86_400 * 45)
    assert keep(clock.now()) == 30
    assert keep(clock.now()) == 18
    assert keep(clock.now()) == 2
    assert DailyFigures.objects.filter(robot=None).count() == 46
    Command.objects.all().delete()
    keep(clock.now())
    assert of(today).commands == 1


def waited(robot, person, now, seconds):
    """A turn that begins now, for which the person waited so long."""
    turn = driven(robot, person, now)
    turn.ticket = Ticket.objects.create(
        queue=queue_of(robot), user=person, state="done", start_tag=0.0, joined_at=now - timedelta(seconds=seconds),
        last_seen=now,
    )  # fmt: skip
    turn.save()
    return turn


def test_waits_success_and_faults_follow_from_their_rows(robot, people, clock, today, client):
    other = Robot.objects.create(slug="other", name="Other", driver="mercury", address="sim:mercury", enabled=True)
    keep(clock.now())
    row = of(today, robot)
    assert (row.wait_median_s, row.wait_longest_s, row.success) == (None, None, None), "nothing happened: not known"
    assert (row.faults, row.outages) == (0, 0)
    turns = [waited(robot, people["ada"], clock.now(), seconds) for seconds in (600, 30, 90)]
    waited(other, people["bob"], clock.now(), 3600)
    driven(robot, people["ada"], clock.now())  # whose ticket is gone with an account
    for state, many in (("completed", 3), ("failed", 1), ("cancelled", 5)):
        for _ in range(many):
            command(robot, turns[0].grant, clock.now(), state=state)
    command(robot, turns[0].grant, clock.now(), state="rejected", accepted_at=None)
    command(other, other.grants.get(), clock.now(), state="unknown")
    for code in ("silent", "limit", OUTAGE):
        incident(robot, code, "It was silent.", clock.now())
    incident(robot, "silent", "Tomorrow.", clock.now() + timedelta(days=1))
    keep(clock.now())
    row, whole = of(today, robot), of(today)
    assert (row.turns, row.wait_median_s, row.wait_longest_s) == (4, 90.0, 600.0)
    assert (whole.wait_median_s, whole.wait_longest_s) == (345.0, 3600.0), "of all people, not of the medians"
    assert (row.commands, row.success) == (9, 0.75)
    assert whole.success == pytest.approx(3 / 5)
    assert of(today, other).success == 0.0
    assert (row.faults, row.outages, whole.faults, whole.outages) == (2, 1, 2, 1)
    assert "Outages" in client.get("/statistics/").content.decode()
    text = client.get("/statistics/?robot=mercury").content.decode()
    for words in ("Wait, median (min)", "1.50", "Commands carried out (%)", "75", "Faults as a table"):
        assert words in text, words
    day = client.get("/statistics.json?robot=mercury").json()["days"]
    assert (day[-1]["wait_median_s"], day[-1]["success"], day[-1]["faults"]) == (90.0, 0.75, 2)
    assert (day[0]["wait_median_s"], day[0]["success"], day[0]["faults"]) == (None, None, None)
    (last,) = list(csv.DictReader(client.get("/statistics.csv").content.decode("utf-8-sig").splitlines()))[-1:]
    assert (last["wait_longest_s"], last["success"], last["outages"]) == ("3600.0", "0.6", "1")


def test_practice_makes_no_wait_and_no_fault(robot, people, clock, today):
    twin = Robot.objects.create(
        slug="twin", name="Twin", driver="mercury", address="sim:mercury", practice_for=robot, clearance_required=False
    )
    waited(twin, people["ada"], clock.now(), 60)
    incident(twin, "silent", "It was silent.", clock.now())
    keep(clock.now())
    assert (of(today).wait_longest_s, of(today).faults) == (None, 0)
    assert not DailyFigures.objects.filter(robot=twin).exists()


def test_a_find_counts_on_the_day_of_its_report_whenever_it_is_decided(robot, people, clock, today):
    mod = people["mod"]
    mod.user_permissions.add(Permission.objects.get(codename="change_find"))
    turn = driven(robot, people["ada"], clock.now())
    bed = Round.objects.create(robot=robot, number=1, began_at=clock.now())
    piece = Piece.objects.create(round=bed, name="zirconium spoon")
    found, other = (
        Find.objects.create(
            round=bed, turn=turn, author=people["ada"], name=name, x=0.1, y=0.4,
            seen_at=clock.now(), reported_at=clock.now(),
        )
        for name in ("a spoon", "a stone")
    )  # fmt: skip
    keep(clock.now())
    assert (of(today).finds, of(today, robot).finds) == (0, 0), "what no moderator has confirmed is not told"
    clock.go(86_400 * 9)
    keep(clock.now())
    decide(found, mod, Find.State.CONFIRMED, piece, clock.now())
    decide(other, mod, Find.State.DECLINED, None, clock.now())
    keep(clock.now())
    assert (of(today).finds, of(today, robot).finds, of(clock.now().date()).finds) == (1, 1, 0)
    decide(found, mod, Find.State.DECLINED, None, clock.now())
    keep(clock.now())
    assert (of(today).finds, of(today, robot).finds) == (0, 0)


def test_days_from_before_this_figure_are_counted_and_what_is_known_of_them_stays(robot, people, clock, today):
    driven(robot, people["ada"], clock.now())
    keep(clock.now())
    clock.go(86_400 * 5)
    keep(clock.now())
    DailyFigures.objects.update(finds=None, faults=None, commands=7)
    keep(clock.now())
    assert (of(today, robot).finds, of(today).finds, of(today).commands) == (0, 0, 7)
    incident(robot, "silent", "It was silent.", clock.now() - timedelta(days=5))
    keep(clock.now())
    assert of(today).faults == 0, "it was counted once"
    DailyFigures.objects.update(faults=None, commands=7)
    keep(clock.now())
    assert (of(today, robot).faults, of(today).faults, of(today).commands) == (1, 1, 7)


def test_a_robot_in_which_nothing_is_hidden_shows_no_finds(robot, some, client, monkeypatch):
    assert ">Finds</h2>" in client.get("/statistics/?robot=mercury").content.decode()
    assert "First find" in client.get("/statistics/").content.decode()
    monkeypatch.setattr("portal.web.daily.views.excavation_of", lambda robot: None)
    assert "Finds" not in client.get("/statistics/?robot=mercury").content.decode()
    assert "finds" in client.get("/statistics.json?robot=mercury").json()["days"][0]


def test_nobody_came_is_zero_only_while_a_web_process_counts(robot, clock, today, monkeypatch):
    monkeypatch.setattr(web_uptime, "up_since", lambda now: now)
    keep(clock.now())
    assert of(today).hits is None
    monkeypatch.setattr(web_uptime, "up_since", lambda now: now - timedelta(minutes=5))
    keep(clock.now())
    assert (of(today).hits, of(today).addresses) == (0, 0)


@pytest.fixture
def some(robot, today):
    for n in range(12):
        for one in (None, robot):
            DailyFigures.objects.create(
                day=today - timedelta(days=n), robot=one, hits=None if n == 2 else 10 * n, addresses=n, turns=n,
                commands=30, entries=0, finds=n % 2, watching=2, online_s=7200.0, sent_bytes=10**9,
            )  # fmt: skip
    return today


def test_the_page_shows_plots_tables_and_milestones_for_everybody(some, client, robot):
    for address in ("/statistics/", "/statistics/?robot=mercury&days=90"):
        answer = client.get(address)
        text = answer.content.decode()
        assert answer.status_code == 200
        for words in (
            "Page views as a table",
            "not known",
            "First turn",
            "100 commands",
            'class="flag"',
            "Hours online",
        ):
            assert words in text, words
        assert "style=" not in text
    assert 'href="/statistics/"' in client.get("/").content.decode()
    assert 'href="/statistics/?robot=mercury"' in client.get("/robots/mercury/").content.decode()


def test_json_and_csv_tell_the_same_and_what_is_missing(some, client):
    told = client.get("/statistics.json").json()
    assert len(told["days"]) == 30
    assert told["days"][-1]["day"] == some.isoformat()
    assert (told["days"][-3]["hits"], told["days"][-2]["hits"], told["days"][0]["hits"]) == (None, 10, None)
    assert told["totals"]["turns"] == {"value": 66, "complete": True}
    assert told["totals"]["hits"]["complete"] is False
    rows = list(csv.DictReader(client.get("/statistics.csv").content.decode("utf-8-sig").splitlines()))
    assert [row["hits"] for row in rows[-3:]] == ["", "10", "0"]
    assert [*rows[0]] == [*told["days"][0]]


@pytest.mark.parametrize(
    "query", [{"days": "1e308"}, {"days": "-1"}, {"until": "soon"}, {"until": "2999-01-01"}, {"until": "0001-01-01"}]
)
def test_a_bad_query_is_a_sentence_with_400(some, client, query):
    for address in ("/statistics/", "/statistics.json", "/statistics.csv"):
        answer = client.get(address, query)
        assert answer.status_code == 400
        assert ("Choose" in answer.content.decode()) or ("last day" in answer.content.decode())
    assert client.get("/statistics/", {"robot": "none"}).status_code == 404


@pytest.mark.timed
@pytest.mark.usefixtures("one_count")
def test_one_address_asks_for_daily_figures_so_often_a_minute(some, client, settings):
    settings.RATE_LIMITS = {"statistics": "2/m/ip"}
    answers = [client.get(f"/statistics{end}") for end in ("/", ".json", ".csv", ".json")]
    assert [answer.status_code for answer in answers] == [200, 200, 429, 429]
    assert answers[3]["Cache-Control"] == "no-store"


def test_a_portal_without_any_row_says_so(robot, client):
    answer = Client().get("/statistics/")
    assert answer.status_code == 200
    html = answer.content.decode()
    assert html.count("Not known for these days") == 1
    assert "<dt>Turns</dt>" in html
    assert "<h2>Turns</h2>" not in html
    assert json.loads(client.get("/statistics.json").content)["milestones"] == []
