"""The scheduler's thread: it keeps its times, and it neither fails in silence nor keeps its worker from ending."""

import gc
import shutil
import signal
import threading
from datetime import timedelta

import pytest
from celery import Celery, beat
from celery.schedules import schedule as every

from tests.conftest import wait_for
from tests.waiting import CEILING_S
from workers.housekeeping import schedule
from workers.housekeeping.schedule import Entry, EvenScheduler, Scheduler, even_now


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    monkeypatch.setattr(schedule, "STOP_S", CEILING_S)


@pytest.fixture
def app():
    found = Celery("scheduled", broker="memory://", set_as_current=False)
    found.conf.beat_schedule = {"tick": {"task": "tick", "schedule": 0.05}}
    with found.connection_for_write() as line:
        queue = line.default_channel
        queue.queue_declare("celery")
        queue.queue_purge("celery")  # queues of memory are the process's: it has what an earlier test sent
    return found


@pytest.fixture
def ended():
    """Whether this process was asked to end."""
    asked = threading.Event()
    before = signal.signal(signal.SIGTERM, lambda *_: asked.set())
    yield asked
    signal.signal(signal.SIGTERM, before)


def sent(app):
    with app.connection_for_read() as line:
        return line.default_channel.queue_declare("celery").message_count


def test_tasks_are_sent_and_the_times_are_kept_at_the_end(app, ended, tmp_path):
    thread = Scheduler(app, str(tmp_path / "times"))
    thread.start()
    wait_for(lambda: sent(app) >= 2, CEILING_S, "two tasks")
    thread.stop()
    assert not thread.is_alive()
    assert list(tmp_path.glob("times*"))
    assert not ended.is_set()


def test_a_scheduler_that_fails_ends_its_worker(app, ended, tmp_path, monkeypatch):
    monkeypatch.setattr(
        beat.Scheduler, "tick", lambda self: (_ for _ in ()).throw(OSError(28, "No space left on device"))
    )
    thread = Scheduler(app, str(tmp_path / "times"))
    thread.start()
    wait_for(ended.is_set, CEILING_S, "the end of its worker")
    thread.stop()
    assert not thread.is_alive()


def test_a_file_that_cannot_be_written_keeps_no_worker_from_ending(app, ended, tmp_path):
    folder = tmp_path / "gone"
    folder.mkdir()
    thread = Scheduler(app, str(folder / "times"))
    thread.start()
    wait_for(lambda: sent(app) >= 1, CEILING_S, "a task")
    shutil.rmtree(folder)
    thread.stop()
    assert not thread.is_alive(), "it does not only give up waiting"
    assert not ended.is_set(), "it was asked to end already"
    folder.mkdir()  # the standard library's shelf tries to write once more when it is collected
    del thread
    gc.collect()


@pytest.mark.parametrize(
    "by", [timedelta(hours=1), -timedelta(hours=1), timedelta(days=20_000), -timedelta(days=20_000)]
)
def test_a_task_stays_due_when_the_time_of_day_is_set(app, monkeypatch, by):
    entry = next(Entry(name="tick", task="tick", schedule=every(1.0, app=app), app=app))
    now = app.now()
    monkeypatch.setattr(app, "now", lambda: now + by)
    assert 0 <= entry.is_due().next <= 1.0
    assert abs(entry.default_now() - entry.last_run_at) < timedelta(hours=1)
    following = next(entry)
    assert 0 < following.is_due().next <= 1.0, "and so does the time after it"
    assert not following.is_due().is_due


@pytest.mark.parametrize("days", [20_000, -20_000])
def test_times_that_were_kept_while_the_date_was_wrong_stop_no_task(app, ended, tmp_path, days):
    file = str(tmp_path / "times")
    kept = EvenScheduler(app, schedule_filename=file)
    kept.schedule["tick"].last_run_at = even_now() + timedelta(days=days)
    kept.close()
    thread = Scheduler(app, file)
    thread.start()
    wait_for(lambda: sent(app) >= 2, CEILING_S, "two tasks")
    thread.stop()
    assert not ended.is_set()
