"""Promises 45 and 46: a hostile socket leaves nothing behind, and strangers delay no command, stop or presence."""

import json
import socket
import struct
import threading
import time

import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from benchmarks.command_round_trip import cookie
from portal.live.messages import Message
from queueing import services as queue
from queueing.models import Ticket
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.states import GrantKind
from tests.conftest import at_length, wait_for
from tests.faults.here import handshake, heard, line

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=30),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=8,
)
KINDS = [t.__struct_config__.tag for t in Message.__subclasses__()]
FIELDS = sorted({name for t in Message.__subclasses__() for name in t.__struct_encode_fields__})
FITTING = {
    "kind": st.sampled_from(["up", "down", "home", "move", "click", "noop"]), "seq": st.integers(1, 99), "n": st.integers(0, 9),
    "args": st.dictionaries(st.sampled_from(["x", "y", "text", "still"]), st.integers() | st.floats(), max_size=3),
    "cameras": st.lists(st.integers(0, 9), max_size=4), "on": st.booleans(), "checked": st.booleans(), "from": st.lists(st.floats(-9, 9), max_size=7),
}  # fmt: skip


@st.composite
def messages(draw):
    """Generate a JSON object that is nearly, or wholly, one of ours."""
    said = (
        {"t": draw(st.sampled_from(KINDS))}
        if draw(st.integers(0, 9))
        else draw(st.dictionaries(st.text(max_size=5), ANYTHING, max_size=3))
    )
    for name in draw(st.lists(st.sampled_from(FIELDS), max_size=4, unique=True)):
        said[name] = draw(FITTING[name] if name in FITTING and draw(st.integers(0, 3)) else ANYTHING)
    return json.dumps(said).encode()


def frame(opcode, data, fin=True):
    size = struct.pack("!B", 0x80 | len(data)) if len(data) < 126 else struct.pack("!BH", 0xFE, len(data) & 0xFFFF)
    return bytes([fin << 7 | opcode]) + size + b"\0\0\0\0" + data


FRAMES = st.one_of(
    messages().map(lambda m: (1, frame(1, m))),
    messages().map(lambda m: (1, frame(1, m))),
    st.text(max_size=60).map(lambda t: (1, frame(1, t.encode("utf8", "replace")))),
    st.binary(max_size=200).map(lambda b: (1, frame(1, b))),
    st.binary(max_size=200).map(lambda b: (1, frame(2, b))),
    st.tuples(messages(), st.integers(2, 90)).map(lambda p: (p[1], frame(1, p[0]) * p[1])),
    st.tuples(st.sampled_from([8, 9, 10]), st.binary(max_size=130)).map(lambda p: (1, frame(p[0], p[1]))),
    st.binary(min_size=1, max_size=40).map(lambda b: (1, b)),
    st.tuples(messages(), st.floats(0, 1)).map(lambda p: (1, frame(1, p[0])[: int(p[1] * len(p[0]))])),
    st.just((1, frame(1, b" " * 9000))), st.just((1, frame(1, b"{", fin=False))),
)  # fmt: skip


class Honest:
    """A viewer that reads; it is sent a numbered state twenty times a second."""

    def __init__(self, web):
        self.delays, self.numbers, self._end = [], [], threading.Event()
        self._line = line(web).__enter__()
        heard(self._line, "snapshot")
        self._threads = [threading.Thread(target=t, daemon=True) for t in (self._send, self._read)]
        for thread in self._threads:
            thread.start()

    def _send(self):
        number = 0
        while not self._end.wait(0.05):
            number += 1
            bus.publish_state("mercury", struct.pack("<BBIqBB", 1, 0, number, time.monotonic_ns(), 0, 1))

    def _read(self):
        while not self._end.is_set():
            try:
                data = self._line.recv(timeout=1)
            except TimeoutError:
                continue
            if isinstance(data, bytes):
                _, _, number, at, _, _ = struct.unpack_from("<BBIqBB", data)
                self.numbers.append(number)
                self.delays.append((time.monotonic_ns() - at) / 1e6)

    def p95(self):
        ordered = sorted(self.delays) or [0.0]
        self.delays = []
        return ordered[int(0.95 * (len(ordered) - 1))]

    def close(self):
        self._end.set()
        for thread in self._threads:
            thread.join(5)
        self._line.close()


@pytest.mark.asvs("1.4.3")
# the web process is in a thread of this one and numbers its pings at random; Hypothesis takes that for a strategy's
@pytest.mark.filterwarnings("ignore:Do not use the `random` module:hypothesis.errors.HypothesisDeprecationWarning")
@pytest.mark.parametrize("round_", [1, at_length(2), at_length(3), at_length(4)])
def test_promise_45_a_hostile_socket_leaves_nothing_behind(web, people, owned, robot, proof, caplog, round_):
    asked = proof.count("messages", 3000, 25_000, 100_000)
    cookies = [None, cookie(people["eve"]), cookie(people["ada"]), cookie(people["kim"])]
    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"], None)
    honest, sent, sockets = Honest(web), 0, 0
    time.sleep(2)
    before = honest.p95()

    @seed(round_)
    @settings(
        max_examples=asked // 12,
        derandomize=False,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.generate],
        database=None,
    )
    @given(
        st.lists(FRAMES, max_size=30),
        st.sampled_from(range(4)),
        st.sampled_from(["mercury", "mercury", "me", "nobody"]),
        st.integers(0, 3),
    )
    def attack(frames, who, where, end):
        nonlocal sent, sockets
        if sent >= asked:
            return
        sockets += 1
        path = "/ws/me/" if where == "me" else f"/ws/robots/{where}/"
        one = socket.create_connection(("127.0.0.1", web.port), timeout=20)
        try:
            one.sendall(handshake(web, path, cookies[who]))
            if end:
                one.recv(100)
            for number, data in frames:
                one.sendall(data)
                sent += number
            if end == 2:
                one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # a reset, not an end
        except OSError:
            pass
        finally:
            one.close()

    try:
        while sent < asked:
            attack()
        during = honest.p95()
        last = honest.numbers[-1]
        wait_for(lambda: honest.numbers[-1] > last, 5, "the honest viewer's next state")
        assert honest.numbers == sorted(honest.numbers)
    finally:
        honest.close()
    web.nothing_left(60)
    assert not [r for r in caplog.records if r.levelname == "ERROR"], caplog.text
    names = [t.name.rpartition("_")[0] for t in threading.enumerate() if "_" in t.name]
    for pool, most in (("urgent", 4), ("known", 8), ("anybody", 4), ("sessions", 2), ("preview", 1)):
        assert names.count(pool) <= most
    wait_for(lambda: not bus.connection().keys("farhand:*:watch:*"), bus.WATCH_S + 1, "the end of the watch keys")
    proof.holds(f"0 viewers, tasks, subscriptions, watch keys left of {sockets} sockets; an honest viewer's states "
                f"p95 {during:.0f} ms late ({before:.0f} ms idle)")  # fmt: skip


@pytest.mark.asvs("15.2.2")
def test_promise_46_strangers_delay_no_command_stop_or_presence(web, people, owned, robot, proof):
    """Everything that strangers can use is taken and does not come back: what must not wait is done all the same."""
    from asgiref.sync import sync_to_async

    from portal.live.previews import PREPARE
    from portal.live.threads import ANYBODY

    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"], None)
    ticket = queue.join(robot, people["bob"], SYSTEM.now())
    free, kept = threading.Event(), []
    with line(web, people["ada"]) as ada, line(web, people["bob"]) as bob, line(web) as stranger:
        for one in (ada, bob, stranger):
            heard(one, "snapshot")

        def fill():
            import asyncio

            for pool in (ANYBODY, PREPARE):
                for _ in range(20):
                    kept.append(asyncio.ensure_future(pool.run(free.wait)))
            kept.append(asyncio.ensure_future(sync_to_async(free.wait, thread_sensitive=True)()))

        web.ask(fill)
        try:
            stranger.send(json.dumps({"t": "join"}))
            for n in range(proof.count("commands", 20, 20)):
                ada.send(json.dumps({"t": "command", "kind": "noop", "args": {}, "seq": n + 1}))
                assert heard(ada, "answer")["ok"]
            seen = Ticket.objects.get(pk=ticket.pk).last_seen
            bob.send('{"t": "ping", "n": 1}')
            wait_for(lambda: Ticket.objects.get(pk=ticket.pk).last_seen > seen, 5, "presence")
            ada.send('{"t": "stop"}')
            assert heard(ada, "answer")["ok"]
            assert Robot.objects.get(pk=robot.pk).stop_latched
            bob.send('{"t": "leave"}')
            assert heard(bob, "answer")["ok"]
            assert not free.is_set()
        finally:
            free.set()
        assert not heard(stranger, "answer")["ok"]
    web.nothing_left()
    proof.holds("20 commands, a stop, presence and a leave done while every thread of strangers' stood still")


@pytest.mark.asvs("15.2.2")
def test_one_persons_sockets_take_no_more_than_their_share_of_the_threads(web, people, owned, robot):
    from portal.live.threads import EACH, KNOWN

    free, running, kept = threading.Event(), [], []

    def fill():
        import asyncio

        def work():
            running.append(1)
            free.wait()

        for _ in range(50):
            kept.append(asyncio.ensure_future(KNOWN.orm(work, people["bob"].pk)()))

    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"], None)
    try:
        with line(web, people["ada"]) as ada:
            heard(ada, "snapshot")
            web.ask(fill)
            ada.send(json.dumps({"t": "command", "kind": "noop", "args": {}, "seq": 1}))
            assert heard(ada, "answer")["ok"]
            wait_for(lambda: len(running) >= EACH, 10, "as many as one person has threads")
            assert len(running) == EACH
    finally:
        free.set()
    wait_for(lambda: len(running) == 50, 10, "all of them")


def test_people_who_wait_delay_no_command_of_who_drives(web, people, owned, robot):
    """All threads of those who wait in queues stand still."""
    from portal.live.threads import KNOWN

    free, kept = threading.Event(), []

    def fill():
        import asyncio

        kept.extend(asyncio.ensure_future(KNOWN.run(free.wait)) for _ in range(20))

    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"], None)
    with line(web, people["ada"]) as ada:
        heard(ada, "snapshot")
        web.ask(fill)
        try:
            for seq in range(1, 6):
                ada.send(json.dumps({"t": "command", "kind": "noop", "args": {}, "seq": seq}))
                assert heard(ada, "answer")["ok"]
            assert not free.is_set()
        finally:
            free.set()
    web.nothing_left()
