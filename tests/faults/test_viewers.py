"""Messages and pictures of a viewer: over a slow line, with any compression, and when a thousand ask at once."""

import contextlib
import json
import select
import signal
import socket
import time

import pytest
from django.conf import settings
from websockets.client import ClientProtocol
from websockets.extensions.permessage_deflate import ClientPerMessageDeflateFactory
from websockets.frames import Frame, Opcode
from websockets.uri import parse_uri

from portal.edge.dropped import dropped
from portal.live import access, shared, snapshot_sender
from portal.live.snapshot import snapshot
from portal.live.snapshot_sender import LEAST_S
from robots import bus
from robots.kit.packets import Changed, Notice
from robots.models import Robot
from tests.conftest import wait_for
from tests.faults.here import closed, heard, line

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

OFFERS = {
    "none": None,
    "deflate": ClientPerMessageDeflateFactory(),
    "small window": ClientPerMessageDeflateFactory(server_max_window_bits=9),
    "each alone": ClientPerMessageDeflateFactory(server_no_context_takeover=True, client_no_context_takeover=True),
}


class Viewer:
    """A viewer who reads only when told, through a small receive buffer."""

    def __init__(self, web, offer="none", buffer=4096, query=""):
        self.line = socket.socket()
        self.line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.line.connect(("127.0.0.1", web.port))
        self.line.settimeout(10)
        where = parse_uri(f"ws://localhost:{web.port}/ws/robots/mercury/{query}")
        extensions = [OFFERS[offer]] if OFFERS[offer] else None
        self.wire = ClientProtocol(where, origin=f"http://localhost:{web.port}", extensions=extensions, max_size=None)
        self.wire.send_request(self.wire.connect())
        self.line.sendall(b"".join(self.wire.data_to_send()))
        self.received = []
        self.until(lambda: any("snapshot" in said for said in self.texts()))

    def read(self, most=65536):
        """Read once; False if the connection is gone."""
        data = self.line.recv(most)
        if data:
            self.wire.receive_data(data)
            self.received += [e for e in self.wire.events_received() if isinstance(e, Frame)]
        return bool(data)

    def until(self, seen, seconds=10):
        until = time.monotonic() + seconds
        while not seen():
            assert time.monotonic() < until
            assert self.read()

    def until_quiet(self, seconds=1.0):
        while select.select([self.line], [], [], seconds)[0] and self.read():
            pass

    def texts(self):
        return [bytes(f.data).decode() for f in self.received if f.opcode is Opcode.TEXT]

    def binary(self):
        return [bytes(f.data) for f in self.received if f.opcode is Opcode.BINARY]

    def pictures(self):
        return [data for data in self.binary() if data[0] == 2]

    def close(self):
        self.line.close()


def picture(n, size=20_000):
    return b"\x02" + n.to_bytes(4, "big") + bytes(size)


def numbers(pictures):
    return [int.from_bytes(p[1:5], "big") for p in pictures]


def notices(viewer):
    told = [json.loads(said) for said in viewer.texts()]
    return [int(said["text"].split()[0]) for said in told if said["t"] == "notice"]


def test_a_viewer_who_reads_slowly_gets_the_newest_picture_and_no_backlog(web):
    slow = Viewer(web)
    with line(web) as quick:
        heard(quick, "snapshot")
        for n in range(1, 201):
            bus.publish_picture("mercury", picture(n))
            time.sleep(0.005)
        last = 0
        while last < 200:
            data = quick.recv(timeout=10)
            last = int.from_bytes(data[1:5], "big") if isinstance(data, bytes) and data[0] == 2 else last
    slow.until_quiet()
    seen = numbers(slow.pictures())
    slow.close()
    assert seen[-1] == 200
    assert seen == sorted(set(seen))
    assert len(seen) <= 6, seen  # what the buffers held when it stopped to read, and the newest
    web.nothing_left()


@pytest.mark.parametrize("offer", OFFERS)
def test_each_message_arrives_whole_and_in_order_whatever_the_compression(web, offer):
    one = Viewer(web, offer, buffer=1 << 20)
    assert bool(one.wire.extensions) == (offer != "none")
    sizes = [0, 1, 120, 121, 126, 65_530, 65_531, 70_000]
    for n, size in enumerate(sizes, 1):
        bus.publish_picture("mercury", picture(n, size))
        bus.publish("mercury", Notice(f"{n} " + "x" * (size % 1000)))
        one.until(lambda n=n: numbers(one.pictures())[-1:] == [n] and notices(one)[-1:] == [n])
    before = len(one.texts())
    bus.publish("mercury", Changed("robot"))
    one.until(lambda: '"snapshot"' in "".join(one.texts()[before:]))
    assert one.pictures() == [picture(n, size) for n, size in enumerate(sizes, 1)]
    assert notices(one) == list(range(1, len(sizes) + 1))
    told = [json.loads(said) for said in one.texts()]
    assert all(said["robot"]["slug"] == "mercury" for said in told if said["t"] == "snapshot")
    one.close()
    web.nothing_left()


def test_events_stay_in_order_for_a_viewer_who_reads_in_bits(web):
    slow = Viewer(web)
    for n in range(1, 91):
        bus.publish("mercury", Notice(f"{n} " + "y" * 900))
        bus.publish_picture("mercury", picture(n, 9000))
        if n % 3 == 0:
            slow.read(2000)
    slow.until_quiet()
    seen = notices(slow)
    slow.close()
    assert seen == sorted(seen)
    assert seen[-1] == 90
    assert numbers(slow.pictures())[-1] == 90


def test_a_viewer_who_takes_nothing_is_dropped_and_counted_and_one_who_takes_a_little_is_not(web, monkeypatch):
    monkeypatch.setitem(settings.LIMITS, "READ_S", 2.0)
    before = dropped["took nothing"]
    dead, slow = Viewer(web), Viewer(web)
    big = picture(1, 2_000_000)
    bus.publish_picture("mercury", big)

    def fell():
        slow.read(3000)
        return dropped["took nothing"] > before

    wait_for(fell, 20, "the one who takes nothing is dropped")
    until = time.monotonic() + 3
    while time.monotonic() < until:
        slow.read(3000)
        time.sleep(0.1)
    assert dropped["took nothing"] == before + 1
    assert web.left()["viewers"] == 1
    slow.until(lambda: slow.pictures() == [big])
    dead.close()
    slow.close()
    web.nothing_left()


def test_what_changed_is_read_once_for_all_who_are_not_signed_in(web, monkeypatch):
    read = []

    def counted(*arguments):
        read.append(1)
        return snapshot(*arguments)

    monkeypatch.setattr(shared, "snapshot", counted)
    crowd = [Viewer(web, buffer=1 << 16) for _ in range(30)]
    wait_for(lambda: web.left()["viewers"] == 30, 5, "all viewers")
    read.clear()
    Robot.objects.update(name="Mercury the Second")
    bus.publish("mercury", Changed("robot"))
    for one in crowd:
        one.until(lambda one=one: "Mercury the Second" in one.texts()[-1])
    assert len(read) <= 2
    for one in crowd:
        one.close()
    web.nothing_left()


def test_what_is_told_right_after_the_snapshot_is_never_missed(web):
    for n in range(1, 41):
        one = Viewer(web)
        bus.publish("mercury", Notice(f"{n} told"))
        one.until(lambda one=one, n=n: n in notices(one))
        one.close()
        web.nothing_left()


def test_a_redis_that_hangs_is_noticed_and_so_is_its_return(web, redis_server):
    with line(web) as one:
        assert heard(one, "snapshot")["link"]
        redis_server.process.send_signal(signal.SIGSTOP)
        try:
            while heard(one, "snapshot", 15)["link"]:
                pass
        finally:
            redis_server.process.send_signal(signal.SIGCONT)
        while not heard(one, "snapshot", 15)["link"]:
            pass
        bus.publish("mercury", Notice("again"))
        assert heard(one, "notice")["text"] == "again"
    web.nothing_left()


def test_more_strangers_than_a_robot_may_have_are_told_so_and_people_who_are_signed_in_are_not(
    web, people, monkeypatch
):
    monkeypatch.setitem(settings.LIMITS, "VIEWERS", 3)
    crowd = [Viewer(web) for _ in range(3)]
    with line(web) as late:
        assert closed(late) == (4503, "As many people watch this robot as the portal can serve. This page tries again.")
    with line(web, people["ada"]) as known:
        assert heard(known, "snapshot")["me"]["signed_in"]
    for one in crowd:
        one.close()
    web.nothing_left()
    with line(web) as again:
        heard(again, "snapshot")
    web.nothing_left()


def newer(one):
    """Return the first snapshot with the robot's new name, and how many came before it."""
    before = 0
    while (said := heard(one, "snapshot"))["robot"]["name"] != "Mercury the Second":
        before += 1
    return said | {"before": before}


def test_what_everybody_sees_is_read_once_for_all_who_are_signed_in_too(web, people, monkeypatch):
    read = []

    def counted(slug, user, *more):
        read.append(user.pk)
        return snapshot(slug, user, *more)

    for room in (shared, snapshot_sender):
        monkeypatch.setattr(room, "snapshot", counted)
    monkeypatch.setattr(access.accounts(), "most", 100)
    with contextlib.ExitStack() as stack:
        crowd = [stack.enter_context(line(web, people[name])) for name in ("bob", "eve") for _ in range(15)]
        for one in crowd:
            heard(one, "snapshot")
        while read:  # a viewer that came before the link to Redis was up gets a second snapshot, and then a pause
            read.clear()
            time.sleep(2 * LEAST_S)
        Robot.objects.update(name="Mercury the Second")
        bus.publish("mercury", Changed("robot"))
        shown = [newer(one) for one in crowd]
        assert [said["me"]["name"] for said in shown] == ["bob"] * 15 + ["eve"] * 15
        assert len(read) <= 2, "one for those who ask at once"
    web.nothing_left()


def test_a_person_who_only_watches_is_sent_no_snapshot_for_each_of_many_changes(web, people):
    with line(web, people["eve"]) as one:
        heard(one, "snapshot")
        begun = time.monotonic()
        for _ in range(60):
            bus.publish("mercury", Changed("frame"))
            time.sleep(0.02)
        Robot.objects.update(name="Mercury the Second")
        bus.publish("mercury", Changed("robot"))
        count = newer(one)["before"]
        assert count <= 2 + (time.monotonic() - begun) / LEAST_S
    web.nothing_left()


def test_an_account_has_so_many_sockets_and_no_more(web, people, monkeypatch):
    monkeypatch.setattr(access.accounts(), "most", 3)
    with contextlib.ExitStack() as stack:
        for _ in range(3):
            heard(stack.enter_context(line(web, people["ada"])), "snapshot")
        with line(web, people["ada"]) as late:
            assert closed(late) == (4503, "You watch robots in as many pages as one account may. Close one of them.")
        with line(web, people["bob"]) as other:
            heard(other, "snapshot")
    web.nothing_left()
    with line(web, people["ada"]) as again:
        heard(again, "snapshot")
    web.nothing_left()
