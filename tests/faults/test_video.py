"""Video over sockets: newcomers, slow viewers, an owner whose encoder fails, and nothing encoded that nobody watches."""

import json
import time
from itertools import pairwise
from urllib.parse import quote

import pytest

from portal.live.video import JOIN_S
from robots import bus
from robots.kit.contract.video import VideoPacket, pack, unpack
from tests.conftest import wait_for
from tests.faults.here import heard, line
from tests.faults.test_viewers import Viewer
from tests.rig import ROOT

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

VIDEO, PICTURE = 4, 2
WISH = {"t": "watch", "cameras": [0], "every_s": 0, "compact": False, "video": "vp9"}
ASKED = "?watch=" + quote(json.dumps(WISH))
PATH = f"/ws/robots/mercury/{ASKED}"


def packet(number, key=False, size=400, run=1, every_ms=100):
    return pack(VideoPacket(0, number, every_ms * number, 0, bytes(size), None if key else number - 1, run))


def pictures(one, many, seconds=10):
    """Return the next packets of pictures that a socket gets, of either kind."""
    found, until = [], time.monotonic() + seconds
    while len(found) < many:
        data = one.recv(timeout=max(0.01, until - time.monotonic()))
        if isinstance(data, bytes) and data[0] in (VIDEO, PICTURE):
            found.append(data)
    return found


def whole(packets):
    told = [unpack(data) for data in packets]
    return told[0].key and all(b.key or (b.follows == a.number and b.run == a.run) for a, b in pairwise(told))


def test_a_newcomer_gets_the_group_since_the_last_key_picture_and_who_wants_jpeg_nothing_of_it(web):
    with line(web, path=PATH) as first, line(web) as plain:
        heard(first, "snapshot")
        heard(plain, "snapshot")
        both = {bus.Demand(), bus.Demand(video=True), bus.Demand(video=True, key=True)}
        wait_for(lambda: bus.demands("mercury", 0) == both, 5, "the wishes of both")
        sent = [packet(n, n in (1, 8)) for n in range(1, 13)]
        for one in sent:
            bus.publish_video("mercury", one)
        assert pictures(first, 12) == sent
        with line(web, path=PATH) as late:
            assert pictures(late, 5) == sent[7:]
            bus.publish_video("mercury", packet(13))
            assert pictures(late, 1) == pictures(first, 1) == [packet(13)]
        bus.publish_picture("mercury", b"\x02" + bytes(50))
        assert pictures(plain, 1)[0][0] == PICTURE, "video never came before it"
        bus.publish_video("mercury", packet(14))
        assert pictures(first, 1) == [packet(14)], "no JPEG came before it"
    web.nothing_left()


def test_a_page_changes_between_video_and_jpeg_on_the_same_socket(web, monkeypatch):
    monkeypatch.setattr("portal.live.video.SILENT_S", 60.0)
    with line(web) as one:
        heard(one, "snapshot")
        one.send(json.dumps(WISH))
        wait_for(lambda: bus.Demand(video=True) in bus.demands("mercury", 0), 5, "the wish")
        for n in range(1, 5):
            bus.publish_video("mercury", packet(n, n == 1))
        assert pictures(one, 4) == [packet(n, n == 1) for n in range(1, 5)]
        time.sleep(JOIN_S)
        asked = time.monotonic()
        one.send(json.dumps(WISH))
        assert len(pictures(one, 4)) == 4, "the group again"
        for _ in range(20):
            one.send(json.dumps(WISH))
        one.send(json.dumps({"t": "ping", "n": 5}))
        while not isinstance(said := one.recv(timeout=10), str) or "pong" not in said:
            assert isinstance(said, str) or time.monotonic() - asked > JOIN_S, "not as often as it asks"
        time.sleep(JOIN_S)
        one.send(json.dumps(WISH))
        assert pictures(one, 4) == [packet(n, n == 1) for n in range(1, 5)], "the whole group again"
        bus.publish_video("mercury", packet(5))
        assert pictures(one, 1) == [packet(5)]
        one.send(json.dumps(WISH | {"every_s": 5}))
        wait_for(lambda: bus.Demand(every_s=bus.RARE_S) in bus.demands("mercury", 0), 5, "the other wish")
        bus.publish_video("mercury", packet(6))
        bus.publish_picture("mercury", b"\x02" + bytes(50))
        assert pictures(one, 1)[0][0] == PICTURE
        one.send(json.dumps(WISH | {"video": "h265"}))
        assert heard(one, "answer")["code"] == "bad_request"
    web.nothing_left()


def test_a_viewer_who_reads_slowly_is_never_given_a_picture_without_those_that_it_changes(web):
    slow = Viewer(web, query=ASKED)
    for n in range(1, 401):
        bus.publish_video("mercury", packet(n, n % 20 == 1, size=6000, every_ms=20))  # as fast as their stamps say
        time.sleep(0.02)
        if n % 10 == 0:
            slow.read(12_000)  # a fifth of what is sent
    slow.until_quiet()
    seen = [data for data in slow.binary() if data[0] == VIDEO]
    assert whole(seen)
    assert 40 < len(seen) < 250, "some of several groups, and no backlog"
    assert unpack(seen[-1]).number > 300, "not of the beginning alone"
    assert sum(unpack(data).key for data in seen) > 2, "it skips to the next key picture"
    bus.publish_video("mercury", packet(401, True, every_ms=20))
    slow.until(lambda: slow.binary()[-1] == packet(401, True, every_ms=20))
    slow.close()
    web.nothing_left()


def test_after_a_packet_was_missed_a_key_picture_is_asked_for(web):
    with line(web, path=PATH) as one:
        heard(one, "snapshot")
        bus.publish_video("mercury", packet(1, True))
        assert pictures(one, 1) == [packet(1, True)]
        bus.end_key_demand("mercury", 0)
        assert bus.Demand(video=True, key=True) not in bus.demands("mercury", 0)
        bus.publish_video("mercury", packet(3))
        wait_for(lambda: bus.Demand(video=True, key=True) in bus.demands("mercury", 0), 5, "the request")
        bus.publish_video("mercury", packet(4))
        bus.publish_video("mercury", packet(5, True))
        assert pictures(one, 1) == [packet(5, True)]
    web.nothing_left()


def test_what_is_not_understood_on_the_bus_drops_nobodys_link(web):
    with line(web, path=PATH) as one:
        heard(one, "snapshot")
        bus.publish_video("mercury", packet(1, True))
        assert pictures(one, 1) == [packet(1, True)]
        store = bus.connection()
        store.publish(bus.video_channel("mercury"), b"no packet")
        store.publish(bus.stream_channel("mercury"), b"\x00")
        store.publish(bus.state_channel("mercury") + "x", b"\xff")
        store.hset(bus.watchers_key("mercury"), "another process", "many")
        assert heard(one, "watchers")
        bus.publish_video("mercury", packet(2))
        while (data := one.recv(timeout=10)) != packet(2):
            assert isinstance(data, bytes) or json.loads(data)["t"] != "snapshot", "the link was dropped"
        wait_for(lambda: store.hget(bus.watchers_key("mercury"), "another process") is None, 10, "the count")
    web.nothing_left()


class Listener:
    """What an owner sends of its camera, whoever gets it."""

    def __init__(self):
        self._channel = bus.listener().pubsub(ignore_subscribe_messages=True)
        self._channel.subscribe(bus.video_channel("mercury"), bus.frames_channel("mercury"))

    def during(self, seconds):
        found, until = [], time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            if message := self._channel.get_message(timeout=left):
                found.append(message["data"])
        return found

    def close(self):
        self._channel.close()


@pytest.fixture
def listener():
    made = Listener()
    yield made
    made.close()


def test_an_owner_encodes_what_is_wanted_once_and_nothing_that_nobody_wants(rig, web, listener):
    rig.owner()
    with line(web, path=PATH) as one, line(web, path=PATH) as two:
        assert whole(pictures(one, 6))
        assert unpack(pictures(two, 1)[0]).number > 0
        listener.during(1.0)
        since, sent = time.monotonic(), listener.during(3.0)
        wait_for(lambda: len(sent) >= 8 or sent.extend(listener.during(0.5)), 30, "packets")  # a busy owner sends few
        assert {data[0] for data in sent} == {VIDEO}, "no JPEG is made that nobody wants"
        numbers = [unpack(data).number for data in sent]
        assert numbers == sorted(set(numbers)), "once for both"
        most = 1 + (time.monotonic() - since) / 2
        assert sum(unpack(data).key for data in sent) <= most, "a group lasts two seconds at least"
    wait_for(lambda: listener.during(1.5) == [], 15, "an idle camera")


def test_an_owner_whose_encoder_fails_goes_on_with_jpeg(rig, web, listener, tmp_path):
    (tmp_path / "av").mkdir()
    (tmp_path / "av" / "__init__.py").write_text("raise ImportError('no encoder on this host')\n")
    owner = rig.owner(PYTHONPATH=f"{tmp_path}:{ROOT}")
    with line(web, path=PATH) as filmed, line(web) as plain:
        heard(filmed, "snapshot")
        assert {data[0] for data in pictures(plain, 8)} == {PICTURE}
        assert VIDEO not in {data[0] for data in listener.during(2.0)}
        filmed.send(json.dumps(WISH | {"video": ""}))
        assert {data[0] for data in pictures(filmed, 4)} == {PICTURE}
    assert owner.alive()
    assert "pictures go on as JPEG" in owner.said()
