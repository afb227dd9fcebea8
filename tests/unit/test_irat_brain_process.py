"""The owner's end of a brain that is stopped in the middle of a picture: nobody waits for it longer than asked."""

import os
import signal
import threading
from concurrent.futures import Future

import pytest

from robots.kit.clock import FasterTimer
from robots.kit.contract.errors import HardwareFault
from robots.kit.drivers.irat.brain import process
from robots.kit.drivers.irat.brain.messages import Feed, Save
from robots.kit.drivers.irat.brain.process import STUCK_S, BrainProcess
from tests.waiting import CEILING_S, wait_for

PICTURE = b"\xff\xd8" + bytes(900_000)  # more than a pipe holds


class Clock(FasterTimer):
    """Real time, and so many seconds later."""

    later = 0.0

    def monotonic(self):
        return super().monotonic() + self.later


def within(work):
    """Return what the work returns, done in a thread; fail if it hangs."""
    found = Future()

    def run():
        try:
            found.set_result(work())
        except BaseException as error:
            found.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    return found.result(CEILING_S)


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def brain(tmp_path, monkeypatch, clock):
    monkeypatch.setattr(process, "SAVED_S", 0.1)
    made = BrainProcess(tmp_path / "brain", lambda packet: None, clock)
    made.start()
    os.kill(made.pid, signal.SIGSTOP)
    yield made
    within(made.close)


def fed(brain):
    return within(lambda: brain.feed(Feed(0.0, 0.0, 0.0, 0.1, PICTURE)))


def test_a_call_to_a_stopped_brain_ends_with_its_deadline_and_so_do_feed_and_close(brain):
    assert [fed(brain), fed(brain)] == [True, False]
    with pytest.raises(HardwareFault, match="does not answer"):
        within(lambda: brain.call(Save, 0.01))
    within(lambda: brain.post(Save(1)))
    pid = brain.pid
    within(brain.close)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_a_brain_that_is_stopped_for_long_is_killed_and_the_next_one_is_fed(brain, clock):
    first = brain.pid
    assert fed(brain)
    clock.later = STUCK_S + 1
    assert not fed(brain)
    wait_for(lambda: brain.starts == 2, CEILING_S, "the next one")
    assert brain.pid != first
    assert fed(brain)
    assert brain.wait(-1e9, CEILING_S) is not None, "it reads what it is fed"


@pytest.mark.parametrize("without", ["brain", "brain-in"])
def test_a_start_without_a_thread_leaves_nothing_behind_and_the_next_one_works(tmp_path, monkeypatch, without):
    real = threading.Thread.start

    def start(thread):
        if thread.name == without:
            raise RuntimeError("can't start new thread")
        real(thread)

    monkeypatch.setattr(process, "SAVED_S", 0.1)
    made = BrainProcess(tmp_path / "brain", lambda packet: None)
    with monkeypatch.context() as patched:
        patched.setattr(threading.Thread, "start", start)
        with pytest.raises(RuntimeError):
            made.start()
    with pytest.raises(ProcessLookupError):
        os.kill(made.pid, 0)
    made.close()
    made.start()
    os.kill(made.pid, 0)
    made.close()
