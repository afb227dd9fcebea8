"""The owner's subscription to stops, when Redis falls silent on it without closing it."""

import threading
from types import SimpleNamespace

import pytest
import redis

from robots import bus
from robots.kit.clock import SYSTEM
from tests.conftest import wait_for
from tests.faults.proxy import Proxy
from workers.guard.listen import Listener

pytestmark = pytest.mark.timed


@pytest.fixture
def listening(redis_server, settings, tmp_path, monkeypatch):
    monkeypatch.setattr(bus.reader, "PING_S", 0.2)
    monkeypatch.setattr(bus.reader, "SILENT_S", 1.5)
    monkeypatch.setattr(bus.store, "OPEN_S", 0.5)
    proxy = Proxy(str(tmp_path / "redis.sock"), settings.REDIS_URL.removeprefix("unix://"))
    direct = settings.REDIS_URL
    settings.REDIS_URL = f"unix://{proxy.at}"
    owned = SimpleNamespace(running=True, clock=SYSTEM, robot=SimpleNamespace(slug="mercury"))
    stops = []
    grants = SimpleNamespace(stop_counts=lambda grant: True)
    made = Listener(owned, SimpleNamespace(halt=stops.append), grants, (), None)

    def again():
        while owned.running:
            made.loop()

    thread = threading.Thread(target=again, daemon=True)
    thread.start()
    yield SimpleNamespace(proxy=proxy, stops=stops, direct=direct)
    owned.running = False
    thread.join(20)
    proxy.close()


def heard(listening):
    count, direct = len(listening.stops), redis.Redis.from_url(listening.direct)

    def once():
        direct.publish(bus.stop_channel("mercury"), b"stop")
        return len(listening.stops) > count

    wait_for(once, 30, "a stop")


def test_a_subscription_on_which_nothing_is_answered_is_opened_anew(listening):
    heard(listening)
    kept = set(listening.proxy._pairs)
    listening.proxy.mode = "half"  # Redis hears, and what it says is lost
    wait_for(lambda: listening.proxy._pairs - kept, 30, "another connection")
    listening.proxy.mode = "pass"
    heard(listening)


def test_an_idle_subscription_is_kept(listening):
    heard(listening)
    kept = set(listening.proxy._pairs)
    threading.Event().wait(4.0)
    assert kept == set(listening.proxy._pairs)
