"""The cache of limits of attempts where Redis answers late."""

import pytest
from django.core.cache import caches
from redis.exceptions import TimeoutError as TooLate

pytestmark = pytest.mark.timed


@pytest.mark.parametrize("late", ["get", "delete"])
def test_a_lock_that_redis_did_not_delete_is_deleted_when_it_answers_again(redis_server, monkeypatch, late):
    cache = caches["default"]

    def too_late(*args, **kwargs):
        raise TooLate("Timeout reading from socket")

    assert cache.add("lock", 1, 60), "the test needs Redis"
    assert cache._shared.get("lock") == 1
    with monkeypatch.context() as patch:
        patch.setattr(cache._shared, late, too_late)
        cache.get("count")
        cache.delete("lock")
    cache._away_until = 0.0
    assert cache.add("lock", 1, 60), "whoever is counted next gets the lock"
    assert not cache._tombstones
