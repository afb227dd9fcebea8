"""The world itself: a seed is a run; processes die as real ones do; a thread that waits elsewhere is named."""

import threading
from math import inf

import pytest
from django.db import connection, transaction

from robots.kit.clock import Until
from tests.world.delays import Delays, These
from tests.world.seeds import fewest
from tests.world.world import Everlasting, World

pytestmark = pytest.mark.django_db(transaction=True)


@pytest.fixture
def opened():
    """Begin worlds that are closed at the end."""
    made = []

    def begin(*args):
        made.append(World(*args))
        return made[-1]

    yield begin
    for world in made:
        world.close()


def told(world, threads=4, rounds=20):
    """Let threads say their names at random times; return what was said."""
    said = []

    def talk(name):
        for i in range(rounds):
            world.sleep(0.01 * (i % 3))
            said.append(name)

    for name in "abcdefgh"[:threads]:
        world.spawn(lambda name=name: talk(name), name)
    world.sleep(5)
    return "".join(said)


def test_a_seed_is_a_run(opened):
    once, again, other = opened(7), opened(7), opened(8)
    assert told(once) == told(again)
    assert once.history == again.history
    assert told(other) != told(opened(7))
    assert len({told(opened(seed)) for seed in range(20)}) > 10, "the seed decides who runs"


def test_nothing_waits_in_real_time_and_nobody_is_early(opened):
    world, ends = opened(1), []
    for seconds in (3600.0, 0.5, 7200.0):
        world.spawn(lambda s=seconds: (world.sleep(s), ends.append(world.monotonic() - 1000.0)), f"{seconds}")
    world.sleep(10_000)
    assert ends == [0.5, 3600.0, 7200.0]


def test_events_conditions_and_locks_are_waited_for(opened):
    world = opened(3)
    event, lock, changed, seen = threading.Event(), world.lock(), threading.Condition(), []

    def waits():
        assert world.wait(event, 5)
        with lock:
            seen.append(("lock", world.monotonic()))
        with changed:
            assert world.wait(Until(changed, lambda: len(seen) > 1), 5)
        seen.append(("changed", world.monotonic()))

    thread = world.spawn(waits, "waits")
    with lock, lock:  # reentrant
        event.set()
        world.sleep(1)
        assert seen == []
    world.sleep(1)
    assert seen == [("lock", 1001.0)]
    with changed:
        seen.append(("told", world.monotonic()))
    thread.join(3)
    assert seen[-1] == ("changed", 1002.0)
    assert not world.wait(threading.Event(), 2.0)
    assert world.monotonic() == 1004.0


def test_a_lock_that_is_not_given_in_time(opened):
    world = opened(1)
    lock = world.lock()
    world.spawn(lambda: (lock.acquire(), world.sleep(100)), "keeps it")
    world.sleep(1)
    assert not lock.acquire(timeout=3)
    assert world.monotonic() == 1004.0
    assert not lock.acquire(blocking=False)


def test_delays_make_threads_late_and_nothing_else(opened):
    busy = opened(5, Delays(5, share=0.3, mean_s=0.2, longest_s=1.0))
    process = busy.process("worker")
    ends = []
    busy.spawn(lambda: [(busy.sleep(0.1), ends.append(busy.monotonic())) for _ in range(50)], "late", process)
    busy.sleep(100)
    given = busy.delays.given
    assert 5 < len(given) < 30
    assert all(0 < late_s <= 1.0 for late_s in given.values())
    assert ends[-1] - 1000.0 == pytest.approx(5.0 + sum(given.values()))
    same = opened(5, These(given))
    again = []
    process = same.process("worker")
    same.spawn(lambda: [(same.sleep(0.1), again.append(same.monotonic())) for _ in range(50)], "late", process)
    same.sleep(100)
    assert again == ends, "delays that are given one by one are the same run"


def test_a_killed_process_does_nothing_more(opened):
    world, done, closed = opened(2), [], []
    process = world.process("worker")
    process.at_kill.append(lambda: closed.append("its file"))

    def works():
        try:
            while True:
                world.sleep(0.1)
                done.append(world.monotonic())
        finally:
            done.append("the end")

    thread = world.spawn(works, "works", process)
    world.sleep(1.05)
    world.kill(process)
    assert closed == ["its file"]
    assert not thread.is_alive()
    world.sleep(10)
    assert len(done) == 10
    world.close()
    assert done[-1] == "the end", "it unwinds when nothing can see it any more"


def test_a_process_that_ends_itself(opened):
    world, done = opened(2), []
    process = world.process("worker")
    world.spawn(lambda: (world.sleep(1), world.kill(process), done.append("after")), "ends", process)
    world.spawn(lambda: (world.sleep(2), done.append("other thread")), "other", process)
    world.sleep(5)
    assert done == []


def test_a_frozen_process_goes_on_where_it_was(opened):
    world, done = opened(2), []
    process = world.process("worker")
    world.spawn(lambda: [(world.sleep(1), done.append(world.monotonic())) for _ in range(3)], "works", process)
    world.sleep(1.5)
    world.freeze(process)
    world.sleep(10)
    assert done == [1001.0]
    world.thaw(process)
    world.sleep(3)
    assert done == [1001.0, 1011.5, 1012.5]


def test_who_waits_inside_a_transaction_is_named(opened):
    world = opened(1)

    def waits():
        with transaction.atomic():
            world.sleep(1)

    world.spawn(waits, "careless")
    world.sleep(2)
    with pytest.raises(AssertionError, match="'careless' died.*inside a transaction"):
        world.check_errors()


def test_a_thread_of_nobody_is_named(opened):
    world, said = opened(1), []

    def waits():
        try:
            world.sleep(1)
        except AssertionError as error:
            said.append(str(error))

    thread = threading.Thread(target=waits, name="stranger")
    thread.start()
    thread.join()
    assert said == ["the thread 'stranger' waits in a world to which it does not belong"]


def test_a_world_in_which_all_wait_for_ever_says_so(opened):
    world = opened(1)
    world.spawn(lambda: world.wait(threading.Event(), inf), "waits")
    with pytest.raises(Everlasting, match="'waits'"):
        world.wait(threading.Event(), inf)


def test_a_thread_that_blocks_outside_is_named(opened, capfd):
    world = opened(1)
    world.named_after_s = 0.05
    outside = threading.Event()
    threading.Timer(1.0, outside.set).start()
    world.spawn(lambda: outside.wait(), "blocks")
    world.sleep(1)
    told = capfd.readouterr().err
    assert "'blocks' has not given way" in told
    assert "outside.wait()" in told


def test_statements_let_others_run_and_transactions_do_not(opened):
    world, seen = opened(1), []

    def reads():
        for _ in range(100):
            seen.append("reads")
            connection.introspection.table_names()

    def writes():
        for _ in range(100):
            with transaction.atomic():
                seen.append("begins")
                connection.introspection.table_names()
                seen.append("ends")

    world.spawn(reads, "reads")
    world.spawn(writes, "writes")
    world.sleep(1)
    assert len(seen) == 300
    begun = [i for i, what in enumerate(seen) if what == "begins"]
    assert all(seen[i + 1] == "ends" for i in begun)
    assert any(seen[i + 2] == "reads" for i in begun[:-1]), "they take turns"


@pytest.mark.parametrize("needed", [{3}, {3, 17}, {1, 2, 40}, set()])
def test_the_fewest_delays_are_found(needed):
    tries = []

    def fails(given):
        tries.append(given)
        return needed <= set(given)

    given = {n: 0.1 for n in range(1, 51)}
    assert set(fewest(given, fails, most=200)) == needed
    assert len(tries) < 200
