"""Promise 31: sockets that are open for a day work as in their first minute; a day's rounds, one after another."""

import ctypes
import gc
import json
import re
import threading
import time
from collections import Counter

import psutil
import pytest
from django.db import connections
from websockets.exceptions import ConnectionClosed

from portal.live import audience, hub, person_socket, sessions, store, writer
from portal.run import serve
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.contract.session import RobotState
from robots.kit.contract.streams import StreamPacket, pack
from robots.kit.packets import Changed, picture_packet, state_packet
from robots.models import Command
from robots.states import CommandState, GrantKind
from tests.conftest import wait_for
from tests.faults.here import WebHere, line
from tests.faults.test_operator_stream import Browser

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

FASTER = 500  # every period is so much shorter
PINGS_FASTER = 250  # more would be a flood: 20 control frames a second are allowed
GROWTH = 5000  # objects; the process holds the pages' ends of the sockets too, so its bytes are told, not judged
STATE, STREAM, PICTURE, COMPACT = 1, 3, 2, 128


class Page:
    """A page that reads what comes, and knows the newest of each kind."""

    def __init__(self, socket):
        self.socket, self.got, self.newest, self.ended = socket, Counter(), {}, None
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        try:
            for data in self.socket:
                what = json.loads(data)["t"] if isinstance(data, str) else data[0]
                self.newest[what] = data
                self.got[what] += 1
        except ConnectionClosed as end:
            self.ended = end

    def say(self, **message):
        self.socket.send(json.dumps(message))

    def more(self, what, act):
        """Do something; wait until another message of that kind has come, and return it."""
        before = self.got[what]
        act()
        wait_for(lambda: self.ended or self.got[what] > before, 10, f"{what} after {self.got}")
        assert not self.ended, self.ended
        return self.newest[what]


@pytest.fixture
def rounds(monkeypatch):
    """Make every period of the web process shorter; count what is done in each."""
    made = Counter()

    def counted(module, name, what):
        plain = getattr(module, name)

        def call(*args, **kwargs):
            made[what] += 1
            return plain(*args, **kwargs)

        monkeypatch.setattr(module, name, call)

    for module, name in (
        (hub, "MARK_S"), (store, "PING_S"), (sessions, "CHECK_S"), (sessions, "APART_S"), (person_socket, "PULSE_S"), (audience, "EVERY_S"),
        (writer, "IDLE_S"),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, getattr(module, name) / FASTER)
    monkeypatch.setattr(bus.demand, "WATCH_S", 1)  # the least that Redis knows
    monkeypatch.setattr(bus.streams, "STREAM_S", 1)
    monkeypatch.setitem(connections.settings["default"], "CONN_MAX_AGE", 0.2)
    counted(hub.Hub, "_keep_watch_once", "the hub")
    counted(sessions, "over", "sessions")
    plain = serve.config

    def config(*args, **kwargs):
        found = plain(*args, **kwargs)
        found.ws_ping_interval = found.ws_ping_interval / PINGS_FASTER
        return found

    monkeypatch.setattr(serve, "config", config)
    return made


@pytest.fixture
def impatient(redis_server):
    """Redis ends connections that are idle for a second, as hosted ones do after some minutes."""
    bus.connection().flushall()
    bus.connection().config_set("timeout", 1)
    yield
    bus.connection().config_set("timeout", 0)


class Owner:
    """A robot's worker, as far as the bus goes: states, pictures, deltas, and what is kept for newcomers."""

    def __init__(self):
        self.number, self._over = 0, threading.Event()
        bus.publish_stream("mercury", 0, [pack(StreamPacket(0, 0, 0, True, b"map"))], True)
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def _work(self):
        while not self._over.wait(0.05):
            self.tell()
            bus.keep_stream("mercury", 0)

    def tell(self):
        self.number += 1
        state = RobotState(0.0, (0.1, 0.2, 0.0, 0.0), (), False, True)
        bus.publish_state("mercury", state_packet(self.number, int(time.time() * 1000), state, False))
        bus.publish_picture("mercury", picture_packet(self.number, int(time.time() * 1000), 0, (), b"jpeg" * 500))

    def stop(self):
        self._over.set()
        self._thread.join()


class Allocated(ctypes.Structure):
    """glibc's `mallinfo2`, over all of its arenas."""

    _fields_ = [(name, ctypes.c_size_t) for name in (
        "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"
    )]  # fmt: skip


def alive():
    """Return how many objects there are, how many bytes malloc has given out, and how many the process has."""
    gc.collect()
    libc = ctypes.CDLL(None)
    libc.mallinfo2.restype = Allocated
    libc.malloc_trim(0)
    told = libc.mallinfo2()
    return len(gc.get_objects()), told.uordblks + told.hblkhd, psutil.Process().memory_full_info().uss


def held(web):
    """Return what the web process holds. A pool begins each of its threads, `known_3`, when it is needed first."""
    names = [thread.name for thread in threading.enumerate()]
    once = {name for name in names if re.fullmatch(r"[a-z]+_\d+", name)}
    return {**web.left(), "threads": len(names) - len(once), "keys": len(bus.connection().keys("*"))}


def all_works(watcher, operator, me, seq):
    """Do everything that a page does, as in its first minute."""
    for page in (watcher, operator):
        for what in (STATE, PICTURE):
            page.more(what, lambda: None)
        page.more("snapshot", lambda: bus.publish("mercury", Changed("robot")))
        page.more("pong", lambda page=page: page.say(t="ping", n=seq))
    said = operator.more("answer", lambda: operator.say(t="command", kind="noop", args={}, seq=seq))
    assert json.loads(said)["ok"], said
    Command.objects.update(state=CommandState.COMPLETED, ended_at=SYSTEM.now())  # as the owner would
    watcher.more(COMPACT, lambda: (watcher.say(t="watch", cameras=[0], compact=True), _compact(watcher)))
    watcher.say(t="watch", cameras=[0])
    me.more("places", lambda: me.say(t="do", what="join", robot="mercury"))
    me.more("places", lambda: me.say(t="do", what="leave", robot="mercury"))
    assert bus.watched("mercury")


def _compact(watcher):
    wait_for(lambda: bus.watched("mercury", "compact"), 5, "compact states are wanted")
    wait_for(lambda: bus.connection().pubsub_numsub(bus.compact_channel("mercury"))[0][1], 5, "and heard")
    bus.publish_compact("mercury", b"\x80 state")


def test_promise_31_day_long_sockets_keep_working(
    transactional_db, rounds, impatient, robot, people, owned, proof
):  # fmt: skip
    number = proof.count("rounds of the hub, of which a day has 43200", 1500, 43_200)
    web, owner = WebHere(), Owner()
    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
    ada = Browser(people["ada"])
    try:
        with line(web) as one, ada.stream(web, ada.code()) as two, line(web, people["bob"], "/ws/me/") as three:
            pages = Page(one), Page(two), Page(three)
            wait_for(lambda: all(page.got for page in pages), 10, "the first words")
            all_works(*pages, seq=1)
            before, known = held(web), alive()
            begun, seq = time.monotonic(), 2
            while rounds["the hub"] < number:
                time.sleep(1.5)  # idle for longer than Redis allows
                all_works(*pages, seq=seq)
                seq += 1
            all_works(*pages, seq=seq)
            with line(web) as newcomer:
                late = Page(newcomer)
                wait_for(lambda: late.got[STREAM], 10, "the map, which was told before all this")
            objects, given, grown = (now - then for now, then in zip(alive(), known, strict=True))
            after = held(web)
            took = time.monotonic() - begun
        assert not {what: (before[what], after[what]) for what in before if after[what] > before[what] + 2}
        assert objects < GROWTH, objects
        web.nothing_left()
    finally:
        owner.stop()
        web.stop()
    proof.holds(f"{rounds['the hub']} rounds of the hub (a day has 43200), {rounds['sessions']} looks at sessions, "
                f"{pages[0].got[STATE]} states, idle connections cut by Redis: 3 sockets open, all as before, "
                f"{objects} objects and {given / 1e6:.1f} MB allocated more, {grown / 1e6:.1f} MB with what malloc keeps, "
                f"the pages' ends included; {took:.0f} s")  # fmt: skip
