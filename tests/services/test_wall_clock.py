"""The wall clock, which detects that the time of day was set and that the machine slept."""

import json
from datetime import timedelta

import pytest

from robots.kit.clock_steps import Reading, step_between
from robots.wall_clock import FIRST, TRUSTED_S, WallClock
from tests.services.clock_steps import HOUR, YEAR

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def test_it_is_noticed_while_the_worker_that_looks_was_started_again(clock, tmp_path):
    seen = []
    for change in (lambda: None, lambda: clock.step(HOUR), lambda: clock.suspend(HOUR), lambda: None):
        change()
        clock.go(5)
        WallClock(tmp_path / "clock", clock).follow(lambda step, now: seen.append((step.shift, step.paused)))
    hour, none = timedelta(hours=1), timedelta()
    assert seen == [(hour, none), (none, hour)]


@pytest.mark.parametrize(("by", "moved", "paused"), [(HOUR, 0, HOUR), (-HOUR, -HOUR, 0), (-74 * YEAR, -74 * YEAR, 0)])
def test_the_time_that_a_machine_was_off_counts_for_nobody(by, moved, paused):
    before = Reading("one boot", 1e9, 5000.0, 4000.0)
    step = step_between(before, Reading("the next", 1e9 + by, 10.0, 10.0))
    assert (step.shift.total_seconds(), step.paused.total_seconds()) == (moved, paused)


@pytest.mark.parametrize(
    "data",
    [b"", b"{", b"null", b"[]", b'{"seen": {}, "doubted_s": 0}', b"\xff" * 100,
     *(json.dumps({"seen": {"boot": "b", "wall": wall, "lasted": 1, "awake": at}, "doubted_s": doubt}).encode()
       for wall, at, doubt in ((1e308, 1, 0), (float("nan"), 1, 0), (float("inf"), 1, 0), ("1", 1, 0), (None, 1, 0),
                               (1e9, 1e308, 0), (1e9, float("nan"), 0), (1e9, 1, float("nan")), (1e9, 1, 1e308)))],
)  # fmt: skip
def test_a_file_with_rubbish_is_as_none(clock, tmp_path, data):
    (tmp_path / "clock").write_bytes(data)
    looks = WallClock(tmp_path / "clock", clock)
    looks.follow(lambda step, now: pytest.fail("nothing was seen before"))
    assert looks.age_now == FIRST
    clock.go(TRUSTED_S)
    looks.follow(lambda step, now: pytest.fail("no step"))
    assert looks.age_now == clock.now()


def test_a_step_that_could_not_be_kept_is_not_carried_again_by_the_next_start(clock, tmp_path, monkeypatch):
    file = tmp_path / "clock"
    looks, seen = WallClock(file, clock), []
    looks.follow(lambda step, now: pytest.fail("nothing was seen before"))
    (tmp_path / "clock.part").mkdir()  # it cannot be written
    clock.step(HOUR)
    for begin in (lambda: looks, lambda: WallClock(file, clock)):
        clock.go(1)
        begin().follow(lambda step, now: seen.append(step.shift.total_seconds()))
    assert seen == [HOUR]


def test_a_disk_that_is_full_stops_no_look(clock, tmp_path):
    (tmp_path / "file").write_bytes(b"")
    looks = WallClock(tmp_path / "file" / "clock", clock)
    seen = []
    for _ in range(2):
        clock.step(HOUR)
        looks.follow(lambda step, now: seen.append(step))
    assert len(seen) == 1


def test_the_clocks_of_this_machine_agree(tmp_path):
    looks = WallClock(tmp_path / "clock")
    for _ in range(3):
        looks.follow(lambda step, now: pytest.fail(str(step)))
