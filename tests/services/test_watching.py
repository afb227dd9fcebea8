"""The number of watchers on the landing page, from what all web processes have told Redis."""

import pytest

from portal.live.watchers import Watchers, watching_now
from robots import bus

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def told(slug, process, strangers, people=(), age_s=0):
    now = bus.connection().time()[0]
    text = Watchers(strangers, frozenset(people), now - age_s).text()
    bus.connection().hset(bus.watchers_key(slug), process, text)


@pytest.fixture
def store(redis_server):
    bus.connection().flushdb()


def test_processes_add_up_a_person_counts_once_and_an_ended_process_not(store):
    told("mercury", "a", 2, {7, 8})
    told("mercury", "b", 1, {8})
    told("mercury", "gone", 50, age_s=60)
    bus.connection().hset(bus.watchers_key("mercury"), "odd", "not a count")
    assert watching_now(["mercury", "irat"]) == {"mercury": 5, "irat": 0}


def test_the_landing_page_says_how_many_watch_and_nothing_where_nobody_does(store, robot, client):
    assert "watching</span>" not in client.get("/").content.decode()
    told("mercury", "a", 3)
    assert '<span class="watching">3 watching</span>' in client.get("/").content.decode()
    for count, words in ((3, "3 schauen zu"), (1, "1 schaut zu")):
        told("mercury", "a", count)
        assert f">{words}</span>" in client.get("/", headers={"accept-language": "de"}).text


def test_without_redis_the_page_says_nothing_of_watchers(robot, client, monkeypatch):
    def dead():
        raise ConnectionError("away")

    monkeypatch.setattr(bus, "connection", dead)
    assert watching_now(["mercury"]) == {}
    assert client.get("/").status_code == 200
