"""Limits of attempts: parallel requests are counted exactly, and none is refused below the limit."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from django.core.cache import cache, caches
from django.test import RequestFactory

from portal.edge import attempts

pytestmark = pytest.mark.service


def asked(address="192.0.2.7"):
    return RequestFactory(REMOTE_ADDR=address).get("/")


@pytest.fixture(params=["memory", "redis"])
def counted(request, one_count):
    """Both places where it is counted; Redis is a real one."""
    if request.param == "redis":
        request.getfixturevalue("redis_server")
        caches["default"]._away_until = 0.0
    cache.clear()
    yield request.param
    cache.clear()


def test_twenty_side_by_side_are_refused_beyond_the_limit_and_never_below(counted, settings):
    settings.RATE_LIMITS = {"slices": "300/h/ip"}
    with ThreadPoolExecutor(20) as pool:
        found = list(pool.map(lambda _: attempts.within(asked(), "slices"), range(400)))
    assert found.count(True) == 300
    assert attempts.within(asked("192.0.2.8"), "slices"), "another address has its own"


def test_each_of_several_limits_holds(counted, settings):
    settings.RATE_LIMITS = {"ask": "3/m/ip,2/h/key"}
    assert [attempts.within(asked(), "ask", "a") for _ in range(3)] == [True, True, False]
    assert not attempts.within(asked(), "ask", "b"), "the address has asked three times"
    assert attempts.within(asked("192.0.2.9"), "ask", "b")


def test_a_count_that_has_run_out_begins_again_and_ends_again(counted, settings, monkeypatch):
    settings.RATE_LIMITS = {"ask": "1/h/ip"}
    assert attempts.within(asked(), "ask")
    assert not attempts.within(asked(), "ask")
    add, gone = cache.add, []

    def added(*args):
        """Have it run out once, between the two steps."""
        return add(*args) or (gone.append(cache.clear()) if not gone else False)

    monkeypatch.setattr(attempts.cache, "add", added)
    assert attempts.within(asked(), "ask")
    assert not attempts.within(asked(), "ask")
