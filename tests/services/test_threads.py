"""A thread of the owner that fails: it goes on, or the robot is held and the owner ends."""

import sys
import threading
from dataclasses import replace
from types import SimpleNamespace

import pytest
import redis
from django.db import OperationalError

from robots import services
from tests.conftest import FakeClock
from tests.services.owner import made_owner
from workers.process.threads import FAILURES, WELL_S, Threads


def run(outcomes):
    """Run a loop with these outcomes, one a call; return how often the owner was ended, and what was left undone.

    None: it goes round and returns; a number: it fails after so many seconds.
    """
    owned, left, ended = SimpleNamespace(running=True, clock=FakeClock()), list(outcomes), []

    def loop():
        outcome = left.pop(0)
        if not left:
            owned.running = False
        owned.clock.go(outcome if isinstance(outcome, float) else 0.0)
        if outcome is not None:
            raise outcome if isinstance(outcome, Exception) else ValueError("after a while")

    def end(why):
        ended.append(why)
        owned.running = False

    threads = Threads(owned, end)
    threads.begin("test", loop)
    threads.join("test", 10.0)
    assert threading.active_count() < 50
    return ended, left


def test_three_failures_in_a_row_end_the_owner():
    ended, left = run([ValueError()] * 10)
    assert (len(ended), len(left), FAILURES) == (1, 7, 3)
    assert "test" in ended[0]


def test_a_loop_that_went_well_for_a_while_begins_to_count_anew():
    assert run([ValueError(), ValueError(), WELL_S + 0.1, 0.0]) == ([], [])


def test_a_loop_that_goes_round_between_failures_has_not_failed_in_a_row():
    assert run([ValueError(), ValueError(), None] * 5) == ([], [])
    ended, _ = run([ValueError(), None, ValueError(), ValueError(), ValueError()])
    assert len(ended) == 1


def never(_):
    pytest.fail("Python's own hook writes to stderr, which waits for ever where nobody reads it")


def die():
    thread = threading.Thread(target=lambda: {}["gone"], name="reader")
    thread.start()
    thread.join()


def test_any_other_thread_that_dies_ends_the_owner(monkeypatch, caplog):
    """A reader of a driver, say; once the owner has ended, it ends nothing more."""
    monkeypatch.setattr("threading.excepthook", never)  # as before, at the end of the test
    owned, ended = SimpleNamespace(running=True), []
    Threads(owned, lambda why: ended.append((why, repr(sys.exception()), caplog.text))).end_with_any()
    for running in (True, False):
        owned.running = running
        die()
    assert ended == [("its thread 'reader' died: KeyError: 'gone'", "KeyError('gone')", "")], (
        "and nothing written before"
    )
    assert (caplog.text.count("Traceback"), "'reader' died" in caplog.text) == (1, True), "the second is told, too"


def test_a_store_that_fails_again_when_its_connection_is_closed_is_waited_for(monkeypatch):
    def fail():
        raise OperationalError("cannot be closed")

    monkeypatch.setattr("workers.process.threads.close_old_connections", fail)
    assert run([OperationalError("gone")] * 5) == ([], [])


@pytest.mark.parametrize("error", [OperationalError("gone"), redis.ConnectionError("gone")])
def test_a_store_that_is_down_is_waited_for(error):
    assert run([error] * 50) == ([], [])


def test_a_store_that_is_down_between_two_failures_does_not_make_them_fewer():
    ended, _ = run([ValueError(), ValueError(), *[OperationalError("gone")] * 5, ValueError(), ValueError()])
    assert len(ended) == 1


def test_an_error_that_has_no_text_ends_the_owner_too(monkeypatch):
    class Mute(Exception):
        def __str__(self):
            raise ValueError("no text")

        __repr__ = __str__

    monkeypatch.setattr("threading.excepthook", never)
    ended = []
    Threads(SimpleNamespace(running=True), ended.append).end_with_any()
    thread = threading.Thread(target=lambda: (_ for _ in ()).throw(Mute()), name="reader")
    thread.start()
    thread.join()
    assert len(ended) == 1


@pytest.mark.service
@pytest.mark.django_db(transaction=True)
@pytest.mark.parametrize("which", ["pa10"], indirect=True)
class TestOwner:
    def test_the_robot_is_held_before_the_owner_ends(self, robot, people):
        told = []
        owner = made_owner(robot, people, on_lost=lambda: told.append("ended"))
        owner.owned.driver.hold = lambda: told.append("held")
        owner.owned.driver.close = lambda: None
        owner.threads.begin("broken", lambda: 1 / 0)
        owner.threads.join("broken", 10.0)
        assert (told, owner.owned.running) == (["held", "ended"], False)

    def test_a_thread_that_dies_holds_the_robot_first_and_its_traceback_is_in_the_log(
        self, robot, people, monkeypatch, caplog
    ):
        monkeypatch.setattr("threading.excepthook", never)
        told = []
        owner = made_owner(robot, people, on_lost=lambda: told.append("Traceback" in caplog.text))
        owner.owned.driver.hold = lambda: told.append(caplog.text)
        owner.owned.driver.close = lambda: None
        owner.threads.end_with_any()
        die()
        assert told == ["", True], "the process ends here"

    @pytest.mark.parametrize("broken", [("hold",), ("close",), ("hold", "close")])
    def test_the_owner_ends_whatever_holding_and_closing_raise(self, robot, people, broken):
        told = []
        owner = made_owner(robot, people, on_lost=lambda: told.append("ended"))

        def part(name):
            def run():
                told.append(name)
                if name in broken:
                    raise ValueError(f"an error of the driver's program in {name}")

            return run

        owner.owned.driver.hold, owner.owned.driver.close = part("hold"), part("close")
        owner.threads.begin("broken", lambda: 1 / 0)
        owner.threads.join("broken", 10.0)
        assert (told, owner.owned.running) == (["hold", "close", "ended"], False)

    def test_a_stopped_owner_gives_its_lease_back_whatever_holding_raises(self, robot, people):
        owner = made_owner(robot, people)
        moving, closed = replace(owner.owned.driver.latest(), moving=True), []
        owner.owned.driver.latest, owner.owned.driver.close = lambda: moving, lambda: closed.append(1)
        owner.owned.driver.hold = lambda: 1 / 0
        owner.connection.connected = True
        owner.stop()
        assert (closed, owner.lease.lost) == ([1], True)

    def test_a_hold_that_fails_too_leaves_no_command_without_its_end(self, robot, people):
        owner = made_owner(robot, people)
        owner.owned.driver.hold = owner.owned.driver.on_the_way = lambda: 1 / 0
        command = services.issue(robot.slug, people["ada"], "ready", {}, 1, owner.owned.now()).command
        with pytest.raises(ZeroDivisionError):
            owner.motion.run_one(command)
        command.refresh_from_db()
        assert (command.state, "could not be held" in command.reason) == ("unknown", True)

    @pytest.mark.parametrize(("where", "state"), [("on_the_way", "unknown"), ("execute", "failed")])
    def test_an_error_of_the_driver_itself_holds_and_leaves_no_word_that_is_untrue(self, robot, people, where, state):
        """During a motion the result is not known; the thread counts this as a failure."""

        def wrong(*_):
            raise KeyError("an error of the driver's program")

        owner = made_owner(robot, people)
        setattr(owner.owned.driver, where, wrong)
        command = services.issue(robot.slug, people["ada"], "ready", {}, 1, owner.owned.now()).command
        with pytest.raises(KeyError):
            owner.motion.run_one(command)
        command.refresh_from_db()
        assert (command.state, owner.owned.driver.holds, "held" in command.reason) == (state, 1, True)
