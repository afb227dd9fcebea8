"""A viewer of a camera's video is never given a packet without those on which it depends, and never many old ones."""

import queue
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.edge.direct import binary_frame
from portal.live.messages import Watch
from portal.live.rooms import Room
from portal.live.video import JOIN_S, LATE_MS, LATER, SILENT_S, VideoCursors, Videos
from portal.live.viewer import Viewer, Wish
from robots.kit.contract.packet_chain import PacketChain
from robots.kit.contract.video import FARTHEST, GROUP_S, HEAD, LONGEST_S, VideoPacket, pack, unpack
from tests.waiting import CEILING_S, wait_for
from workers.media.video import KEYS_S, Shot, Video

EVERY_MS = 100
BYTES = b"vp8"


class Watcher:
    """A viewer whose line is free or busy as the test says; it checks what it is given."""

    def __init__(self, camera=0):
        self.camera, self.video_cursors, self.free, self.woken = camera, VideoCursors(), True, False
        self.got = []

    def films(self, camera):
        return camera == self.camera

    def ready(self):
        return self.free and not self.woken

    def write(self, frame):
        data = frame[4 if frame[1] == 126 else 2 :]
        assert frame == binary_frame(data)
        self.take(unpack(data))

    def take(self, packet):
        assert packet.key or (self.got and packet.follows == self.got[-1].number and packet.run == self.got[-1].run)
        self.got.append(packet)

    def wake(self):
        self.woken = True

    def empty(self, videos, now):
        if self.free and self.woken:
            packets = [unpack(data) for data in videos.take_missing(self, now)]
            self.woken = False
            for packet in packets:
                self.take(packet)
            return packets
        return []


def film(count, keys, camera=0, run=3):
    """Return packets of one encoder; `keys` says where a key picture stands beside the first."""
    made = []
    for n in range(1, count + 1):
        follows = None if n == 1 or n in keys else n - 1
        made.append(pack(VideoPacket(camera, n, 1000 + n * EVERY_MS, 0, BYTES, follows, run)))
    return made


@given(st.sets(st.integers(2, 60), max_size=8), st.data())
def test_whatever_a_line_does_and_whatever_is_lost_each_packet_follows_the_one_before(keys, data):
    videos, late, asked = Videos(), Watcher(), 0
    watchers = [Watcher(), late]
    late_from = data.draw(st.integers(1, 60))
    for n, packet in enumerate(film(60, keys), 1):
        now = n * EVERY_MS / 1000
        if data.draw(st.integers(0, 9)) == 0:
            continue  # lost on the way to this process
        here = [w for w in watchers if w is not late or n >= late_from]
        asked += not videos.give(0, packet, here, now)
        for one in here:
            one.free = data.draw(st.booleans())
            given_now = one.empty(videos, now)
            if len(one.got) > len(given_now):  # no newcomer
                assert not given_now or given_now[-1].at_ms - given_now[0].at_ms <= LATE_MS
    for one in watchers:
        assert all(b.key or b.follows == a.number for a, b in pairwise(one.got))


def test_a_newcomer_gets_the_group_since_the_last_key_picture_at_once_and_then_what_comes():
    videos, packets = Videos(), film(30, {15})
    for n, packet in enumerate(packets[:25], 1):
        videos.give(0, packet, [], n / 10)
    one = Watcher()
    one.wake()
    one.empty(videos, 2.5)
    assert [p.number for p in one.got] == list(range(15, 26))
    for n, packet in enumerate(packets[25:], 26):
        videos.give(0, packet, [one], n / 10)
    assert [p.number for p in one.got] == list(range(15, 31))


def test_a_slow_viewer_is_given_little_that_it_missed_and_otherwise_skips_to_the_next_key_picture():
    videos, packets, one = Videos(), film(60, {41}), Watcher()
    busy = {**dict.fromkeys(range(6, 9), True), **dict.fromkeys(range(20, 30), True)}
    for n, packet in enumerate(packets, 1):
        one.free = n not in busy
        one.empty(videos, n / 10)
        videos.give(0, packet, [one], n / 10)
    assert [p.number for p in one.got] == [*range(1, 20), *range(41, 61)]


def test_a_slow_viewer_is_given_all_that_it_missed_if_that_is_no_more_bytes_than_a_key_picture():
    for size, skips in ((40, False), (41, True)):
        videos, one = Videos(), Watcher()
        for n in range(1, 41):
            one.free = not 5 <= n < 22
            one.empty(videos, n / 10)
            data = bytes(1000 if n == 1 else size)
            videos.give(0, pack(VideoPacket(0, n, 100 * n, 0, data, n - 1 if n > 1 else None)), [one], n / 10)
        assert 17 * (size + HEAD.size) - (1000 + HEAD.size) == (17 if skips else 0)
        assert [p.number for p in one.got] == list(range(1, 5 if skips else 41))


def test_who_asks_again_within_a_second_is_given_the_group_then_and_not_before():
    videos, one = Videos(), Watcher()
    one.video_cursors[0], one.video_cursors.joins_from = LATER, JOIN_S
    for n, packet in enumerate(film(20, {4}), 1):
        now = n / 10
        if n > 4:
            videos.give(0, packet, [one] if n > 5 else [], now)
            assert bool(one.got) == (now > JOIN_S), n
            one.empty(videos, now)
        else:
            videos.give(0, packet, [], now)
    assert [p.number for p in one.got] == list(range(4, 21))


def test_who_has_fallen_far_behind_is_not_woken_before_the_next_key_picture():
    videos, packets, one = Videos(), film(30, {25}), Watcher()
    woken = []
    for n, packet in enumerate(packets, 1):
        one.free = not 5 <= n < 15
        one.empty(videos, n / 10)
        one.woken = one.woken and not one.free
        videos.give(0, packet, [one], n / 10)
        woken += [n] * one.woken
    assert [p.number for p in one.got] == [*range(1, 5), *range(25, 31)]
    assert woken == list(range(5, 15))


def test_after_a_silence_nothing_old_is_given_and_a_key_picture_is_asked_for():
    room, viewer = Room("mercury"), Viewer("mercury", wish=Wish(video="vp8"))
    room.add(viewer)
    assert room.watched() == {"video"}
    assert room.keys() == {"video.key"}
    videos, packets = Videos(), film(3, set())
    for packet in packets:
        assert videos.give(0, packet, [], 10.0)
    assert videos.flows(0, 10.0 + SILENT_S - 0.1)
    assert not videos.flows(0, 10.0 + SILENT_S)
    one = Watcher()
    assert videos.take_missing(one, 10.0 + SILENT_S) == []
    assert videos.take_missing(one, 10.0) == packets
    assert videos.take_missing(one, 10.0) == []
    orphan = pack(VideoPacket(0, 9, 2000, 0, BYTES, 8, 3))
    assert [videos.give(0, orphan, [one], 11.0) for _ in range(3)] == [False, True, True], "asked for once"
    assert videos.take_missing(Watcher(), 11.0) == []


def test_who_wants_a_picture_now_and_then_or_cannot_decode_gets_jpeg():
    room = Room("arm")
    wishes = {
        (0.0, "vp8", False): "video1", (0.0, "", False): "frames1", (5.0, "vp8", True): "frames1.rare",
        (1.0, "", False): "frames1.slow", (0.4, "", False): "frames1.some",
        (0.0, "vp8", True): "coarsevideo1", (0.0, "", True): "coarse1",
    }  # fmt: skip
    for (every_s, video, coarse), name in wishes.items():
        viewer = Viewer("arm", wish=Wish.of(Watch([1], every_s, video=video, coarse=coarse)))
        room.add(viewer)
        assert room.watched() == {name}
        assert viewer.films(1) is name.endswith("video1")
        groups = [room.film[1, bool(coarse and not every_s)], room.each[1, bool(coarse and not every_s)], room.some[1]]
        assert [viewer in group for group in groups] == [viewer.films(1), not every_s and not video, every_s > 0]
        room.remove(viewer)


def test_a_jpeg_picture_is_not_kept_when_newer_ones_come_as_video_alone():
    room, plain = Room("arm"), Viewer("arm")
    packets = film(3, set())
    room.add(plain)
    room.give_picture(0, b"\x02 old")
    room.give_video(0, packets[0], False)
    assert room.newest == {0: b"\x02 old"}, "JPEG is made as well"
    room.remove(plain)
    room.give_video(0, packets[1], False)
    assert room.newest == {}


@given(st.binary(max_size=60))
def test_any_bytes_are_a_packet_or_refused(data):
    try:
        packet = unpack(data)
    except ValueError:
        return
    if packet.follows is None or packet.number > packet.follows:
        assert unpack(pack(packet)) == packet
    PacketChain(unpack).add(data)


def test_a_picture_too_far_back_cannot_be_followed():
    for follows in (700, 701, 700 - FARTHEST - 1):
        with pytest.raises(ValueError, match="follows one at most"):
            pack(VideoPacket(0, 700, 0, 0, BYTES, follows))
    for data in (b"", b"\x04" * 20, b"\x03" * 40):
        with pytest.raises(ValueError, match="not a packet of video"):
            unpack(data)


def decoded(packets, coding):
    """Return the pictures' levels of a run of packets, decoded."""
    import av

    decoder = av.CodecContext.create(coding, "r")
    frames = [f for data in packets for f in decoder.decode(av.Packet(unpack(data).data))]
    rows = [np.frombuffer(f.planes[0], np.uint8).reshape(f.height, -1)[:, : f.width] for f in frames]
    return rows, frames


def scene(n, shape=(165, 191)):
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    grey = (128 + 125 * np.sin((rows + columns + 3 * n) / 9)).astype(np.uint8)
    return grey if len(shape) == 2 else np.dstack([grey, 255 - grey, grey])


def begins_in_time(packets):
    """Tell whether whoever joins is given no more than 2 s or twice a key picture, and never more than 10 s."""
    begun_ms, most, since = 0, 0, 0
    for data in packets:
        packet = unpack(data)
        if packet.key:
            begun_ms, most, since = packet.at_ms, len(data), 0
            continue
        if packet.at_ms - begun_ms >= (1000 * GROUP_S if since >= most else 1000 * LONGEST_S):
            return False
        since += len(data)
    return True


@pytest.mark.parametrize("coding", ["vp8", "vp9"])
@pytest.mark.parametrize("shape", [(165, 191), (120, 160, 3)], ids=["grey, odd", "colour"])
def test_what_is_encoded_is_the_picture_and_each_group_begins_in_time(shape, coding):
    video = Video("rover", 2, coding=coding)
    packets = [video.packet(Shot(scene(n, shape), n, n % 3, 1000 + 250 * n)) for n in range(1, 25)]
    told = [unpack(p) for p in packets]
    assert [(p.camera, p.number, p.still, p.at_ms) for p in told] == [
        (2, n, n % 3, 1000 + 250 * n) for n in range(1, 25)
    ]
    assert told[0].key
    assert begins_in_time(packets)
    assert all(p.key or p.follows == p.number - 1 for p in told)
    levels, frames = decoded(packets, coding)
    assert len(levels) == len(packets), "each picture can be shown as soon as it comes"
    for n, (found, frame) in enumerate(zip(levels, frames, strict=True), 1):
        wanted = scene(n, shape)
        back = (
            found
            if wanted.ndim == 2
            else frame.to_ndarray(format="bgr24", src_colorspace="ITU601", src_color_range="JPEG")
        )
        assert np.abs(back.astype(int) - wanted).mean() < 8
    if len(shape) == 2:
        assert levels[3].min() < 12, "levels of the full range"
    if coding == "vp9":
        assert frames[0].color_range == 2, "it says so of itself"


def keys_of(pictures, every_ms=250):
    """Return when (ms) a key picture comes, of pictures taken one after the other; and all packets."""
    video = Video("rover", 0)
    packets = [video.packet(Shot(one, n, 0, n * every_ms)) for n, one in enumerate(pictures)]
    return [unpack(data).at_ms for data in packets if unpack(data).key], packets


def test_where_much_changes_a_group_lasts_two_seconds_and_where_nothing_does_ten():
    rng = np.random.default_rng(1)
    keys, packets = keys_of([rng.integers(0, 255, (80, 96), np.uint8) for _ in range(40)])
    assert keys == list(range(0, 10_000, int(1000 * GROUP_S)))
    keys, packets = keys_of([rng.integers(0, 255, (80, 96), np.uint8)] * 100)
    assert keys == list(range(0, 25_000, int(1000 * LONGEST_S)))
    first = next(n for n, data in enumerate(packets) if n and unpack(data).key)
    assert sum(map(len, packets[1:first])) <= len(packets[0]), "whoever joins late is given little"


@given(st.lists(st.tuples(st.sampled_from(["still", "moves", "new"]), st.integers(1, 2500)), min_size=2, max_size=60))
def test_whatever_is_filmed_whoever_joins_is_given_little(shots):
    rng, video, at_ms, packets, n = np.random.default_rng(2), Video("rover", 0), 0, [], 0
    for number, (what, wait_ms) in enumerate(shots, 1):
        at_ms, n = at_ms + wait_ms, n + (what == "moves")
        picture = rng.integers(0, 255, (48, 64), np.uint8) if what == "new" else scene(n, (48, 64))
        packets.append(video.packet(Shot(picture, number, 0, at_ms)))
        assert unpack(packets[-1]).key or wait_ms < 1000 * GROUP_S, "after a pause it begins anew"
    assert begins_in_time(packets)


def test_a_key_picture_comes_when_it_is_asked_for_but_not_at_each_request():
    video = Video("rover", 0)
    keys = [unpack(video.packet(Shot(scene(n), n, 0, 100 * n), wants_key=n > 2)).key for n in range(1, 15)]
    first = keys.index(True, 1)
    assert first * 0.1 >= KEYS_S
    assert [n for n, key in enumerate(keys) if key] == list(range(0, 14, first))


def test_a_request_is_kept_until_a_key_picture_is_encoded_and_is_answered_then(monkeypatch):
    sent, told = queue.Queue(), []
    fake = SimpleNamespace(
        publish_video=lambda *what: sent.put(what[1]), end_key_demand=lambda *what: told.append(what)
    )
    monkeypatch.setattr("workers.media.video.bus", fake)
    video = Video("rover", 0)
    video.take(Shot(scene(1), 1, 0, 100))
    assert unpack(sent.get(timeout=CEILING_S)).key
    assert told == [], "nobody had asked"
    keys = []
    for n in range(2, 9):
        video.take(Shot(scene(n), n, 0, 100 * n), key=n == 2)
        keys.append(unpack(sent.get(timeout=CEILING_S)).key)
        if not any(keys):
            assert told == [], "too soon after the last one: the request waits"
    assert keys == [n == 1 + 10 * KEYS_S for n in range(2, 9)]
    assert told == [("rover", 0, False)]


def test_where_no_thread_can_start_the_video_rests_for_a_while(monkeypatch, caplog):
    def refuse(thread):
        raise RuntimeError("can't start new thread")

    video = Video("rover", 0)
    with monkeypatch.context() as without:
        without.setattr("threading.Thread.start", refuse)
        video.take(Shot(scene(1), 1, 0, 100))
    assert not video.running
    assert "pictures go on as JPEG" in caplog.text
    video.take(Shot(scene(2), 2, 0, 200))
    assert not video.running, "not at once again"


def test_another_size_or_a_gap_begins_a_new_group_and_another_size_a_new_run():
    video = Video("rover", 0)
    shots = [
        Shot(scene(1), 1, 0, 0), Shot(scene(2), 2, 0, 100), Shot(scene(3, (80, 90)), 3, 0, 200),
        Shot(scene(4, (80, 90)), 4, 0, 300), Shot(scene(5, (80, 90)), 5 + FARTHEST, 0, 400),
    ]  # fmt: skip
    told = [unpack(video.packet(shot)) for shot in shots]
    assert [p.key for p in told] == [True, False, True, False, True]
    assert told[0].run == told[1].run != told[2].run == told[4].run


def test_a_packet_that_cannot_be_sent_ends_the_video_for_a_while(monkeypatch, caplog):
    """Its thread is not to die with the video said to run for ever."""
    monkeypatch.setattr("workers.media.video.bus", SimpleNamespace(publish_video=lambda *told: {}["gone"]))
    video = Video("rover", 0)
    video.take(Shot(scene(1), 1, 0, 0))
    wait_for(lambda: not video.running, CEILING_S, "its end")
    assert "pictures go on as JPEG" in caplog.text


def test_a_failure_ends_the_video_for_a_while_and_nothing_else(monkeypatch, caplog):
    sent = []
    monkeypatch.setattr("workers.media.video.bus", SimpleNamespace(publish_video=lambda *told: sent.append(told)))
    video = Video("rover", 0)
    video.take(Shot(np.zeros((0, 0), np.uint8), 1, 0, 0))  # no picture
    thread = video._thread
    if thread is not None:
        thread.join(CEILING_S)
    assert not video.running
    assert "pictures go on as JPEG" in caplog.text
    video.take(Shot(scene(2), 2, 0, 100))
    assert not video.running
    monkeypatch.setattr("workers.media.video.PAUSE_S", 0.0)
    video._paused_until = 0.0
    video.take(Shot(scene(3), 3, 0, 200))
    wait_for(lambda: sent, CEILING_S, "its packet")
    assert [unpack(packet).number for _, packet, *_ in sent] == [3]
    assert unpack(sent[0][1]).key
