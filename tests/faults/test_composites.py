"""Motion JPEG at the real web process: drawn while watched, once for all, within limits, and ended with the owner."""

import asyncio
import contextlib
import http.client
import re
import threading
import time
from datetime import timedelta

import cv2
import numpy as np
import pytest
import redis
from django.conf import settings

from portal.keep.seeding import add_robot
from portal.web.composites.drawing import shared_drawing
from portal.web.composites.parts import HEAD, watchers
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.capabilities import Composite
from robots.kit.contract.find import spec_of
from robots.kit.contract.session import RobotState
from robots.kit.contract.streams import StreamPacket, pack
from robots.kit.packets import picture_packet, state_packet
from robots.models import Frame, Lease, Robot
from tests.conftest import wait_for
from tests.rig import Web
from tests.unit.test_irat_composites import RING

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

DESKTOP, PHONE = "/robots/irat/live/desktop.mjpg", "/robots/irat/live/phone.mjpg"
SPEC = spec_of("irat")


class Teller:
    """Publishes as an owner does: ten states a second, each another one, a picture, the map."""

    def __init__(self):
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._tell, daemon=True)
        self.number, self.behind_s, self.sees = 0, 0.0, True
        self.view = cv2.imencode(".jpg", np.full((240, 416, 3), 90, np.uint8))[1].tobytes()
        bus.publish_stream("irat", 0, [pack(StreamPacket(0, 1, 1, True, RING))], from_key=True)
        self._thread.start()

    def _tell(self):
        while not self._over.wait(0.1):
            self.number += 1
            now = int(time.time() * 1000)
            told = RobotState(0.0, (), (0.2, 0.1, self.number / 10), True, True, mode=f"step {self.number}")
            state = state_packet(self.number, now, told, False, SPEC.packed(), SPEC.named(told))
            both = bus.connection().pipeline()  # at once, so that nothing is drawn between them
            both.publish(bus.state_channel("irat"), state)
            if self.sees:
                at_ms = now - int(1000 * self.behind_s)
                both.publish(bus.frames_channel("irat"), picture_packet(self.number, at_ms, 0, (), self.view))
            with contextlib.suppress(redis.RedisError):  # a packet is lost where Redis answers too late
                both.execute()

    def stop(self):
        self._over.set()
        self._thread.join()


@pytest.fixture
def served(transactional_db, redis_server):
    bus.connection().flushall()
    robot = add_robot("irat")
    Lease.objects.create(robot=robot, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
    web = Web(FARHAND_COMPOSITES_PER_ADDRESS="3", FARHAND_COMPOSITE_VIEWERS="5")
    teller, opened = Teller(), []

    def watch(path=DESKTOP, source="127.0.0.1"):
        line = http.client.HTTPConnection("127.0.0.1", web.port, timeout=15, source_address=(source, 0))
        line.request("GET", path, headers={"Host": "localhost"})
        opened.append(line)
        answer = line.getresponse()
        answer.line = line
        return answer

    yield watch, teller
    teller.stop()
    for line in opened:
        line.close()
    assert web.alive(), web.said()
    assert "Traceback" not in web.said()
    web.kill()


def leave(*answers):
    for answer in answers:
        answer.close()
        answer.line.close()


def part(answer):
    """Read one part; None at the closing boundary."""
    if not hasattr(answer, "begun"):
        answer.begun = [answer.readline() for _ in range(3)] == HEAD.splitlines(keepends=True)
        assert answer.begun
    lines = [b""]
    while lines[-1] not in (b"--farhand\r\n", b"--farhand--"):
        lines.append(answer.readline())
        assert lines[-1], "the answer is complete"
    if lines[-1] == b"--farhand--":
        return None
    assert lines[-1] + answer.readline() + answer.readline() == HEAD
    return b"".join(lines[:-1]).removesuffix(b"\r\n")


class Newest:
    """Reads a stream as fast as it comes and keeps the last picture: who looks at each one falls behind."""

    def __init__(self, answer):
        self._over, self._answer, self.jpeg = threading.Event(), answer, part(answer)
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self):
        while not self._over.is_set():
            self.jpeg = part(self._answer)

    def stop(self):
        self._over.set()
        self._thread.join()


@pytest.mark.asvs("15.2.2")
def test_it_is_drawn_while_watched_and_once_for_all(served):
    watch, _ = served
    assert not bus.watched("irat", "frames")
    one, other = watch(), watch()
    assert one.status == 200
    assert one.headers["Content-Type"] == "multipart/x-mixed-replace; boundary=farhand"
    seen = [], []
    while len(seen[0]) < 40 and (len(seen[0]) < 12 or len(set(seen[0]) & set(seen[1])) < 9):  # one has begun earlier
        for answer, parts in zip((one, other), seen, strict=True):
            parts.append(part(answer))
    shapes = {cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR).shape for jpeg in seen[0]}
    assert shapes == {(460, 780, 3)}
    assert len(set(seen[0])) > 8, "the picture moves"
    assert len(set(seen[0]) & set(seen[1])) > 8, "both get the same bytes"
    assert bus.watched("irat", "frames")
    phone = watch(PHONE)
    small = cv2.imdecode(np.frombuffer([part(phone) for _ in range(4)][-1], np.uint8), cv2.IMREAD_COLOR)
    assert small.shape == (480, 320, 3)
    assert (np.abs(small.astype(int) - (60, 60, 235)).max(axis=2) < 60).any(), "the route of the stream is drawn"
    leave(one, other, phone)
    wait_for(lambda: not bus.watched("irat", "frames"), 15, "nobody watches any more")


def test_all_watchers_are_given_the_same_drawing(served):
    watch, _ = served
    del watch
    composite = SPEC.all_of(Composite)[0]

    async def looked():
        one, other = shared_drawing("irat", SPEC, composite), shared_drawing("irat", SPEC, composite)
        assert one is other
        same = 0
        with one.watched(), other.watched():
            assert watchers("irat") == 2
            mine, theirs = one.parts(), other.parts()
            for _ in range(15):
                told = await asyncio.gather(anext(mine), anext(theirs))
                same += told[0] is told[1]
            assert one.frames <= 17, "one drawing for both"
        assert one.over
        assert watchers("irat") == 0
        with shared_drawing("irat", SPEC, composite).watched():
            assert watchers("irat") == 1, "who comes later has it drawn again"
        return same

    assert asyncio.run(looked()) >= 13


def test_who_reads_slowly_skips_pictures_and_gets_the_newest(served):
    composite = SPEC.all_of(Composite)[0]

    async def looked():
        one, read = shared_drawing("irat", SPEC, composite), []
        with one.watched():
            parts = one.parts()
            for _ in range(4):
                read.append(await anext(parts))
                begun = one.frames
                while one.frames < begun + 4:
                    await asyncio.sleep(0.02)
            newest = await anext(parts)
            assert newest is one._part
            return len({*read, newest}), one.frames

    seen, frames = asyncio.run(looked())
    assert seen == 5
    assert frames >= 16, "the drawing did not wait for the reader"


@pytest.mark.asvs("2.4.1", "15.2.2")
def test_viewers_are_limited_by_address_and_by_robot_and_leave_their_place(served):
    watch, _ = served
    mine = [watch() for _ in range(3)]
    assert [part(answer) is not None for answer in mine] == [True] * 3
    refused = watch()
    assert refused.status == 429
    assert refused.read().decode().startswith("Your network address watches")
    others = [watch(source=f"127.0.0.{n}") for n in (2, 3)]
    assert [part(answer) is not None for answer in others] == [True] * 2
    full = watch(source="127.0.0.4")
    assert (full.status, full.headers["Retry-After"]) == (503, "30")
    leave(*mine, *others)

    def free():
        again = watch()
        found = again.status == 200 and part(again) is not None
        leave(again)
        return found

    wait_for(free, 15, "the places are free again")


def test_who_does_not_read_delays_nobody(served):
    watch, _ = served
    slow, quick = watch(), watch()
    assert part(slow) is not None
    read = [part(quick) for _ in range(30)]
    assert None not in read
    assert len(set(read)) > 25, "each is a new one"
    assert part(slow) is not None, "it goes on where it was left"


def test_the_stream_ends_cleanly_when_the_owner_is_gone(served):
    watch, teller = served
    answer = watch()
    assert part(answer) is not None
    teller.stop()
    while (left := part(answer)) is not None:
        assert left
    assert answer.read() == b"", "the answer is complete"
    Lease.objects.update(expires_at=SYSTEM.now() - timedelta(seconds=1))
    offline = watch()
    assert (offline.status, offline.read()) == (503, b"This robot is offline now; try again later.\n")


def test_a_camera_that_sends_nothing_any_more_ends_its_stream_though_the_robot_is_there(served):
    watch, teller = served
    answer = watch(CAMERA)
    assert part(answer) is not None
    teller.sees = False
    while part(answer) is not None:
        pass
    assert answer.read() == b"", "the answer is complete"
    assert part(watch()) is not None, "the drawing goes on"


def test_a_drawing_shows_no_picture_of_a_camera_that_sends_nothing_any_more(served):
    watch, teller = served
    newest = Newest(watch())

    def sees():
        """Tell whether the camera's grey wall is in the drawing."""
        shown = cv2.imdecode(np.frombuffer(newest.jpeg, np.uint8), cv2.IMREAD_COLOR).astype(int)
        return (np.abs(shown - 90).max(axis=2) < 6).mean() > 0.1

    wait_for(sees, 15, "the picture")
    teller.sees = False
    wait_for(lambda: not sees(), 30, "the end of a picture that is old")
    teller.sees = True
    wait_for(sees, 15, "the picture")
    newest.stop()


def test_a_clock_of_the_robot_s_host_that_is_behind_hides_no_picture(served):
    watch, teller = served
    teller.behind_s = 60
    one = watch(CAMERA)
    assert part(one) == teller.view
    assert ask(NEWEST)(one.line.port).status == 302


def test_what_cannot_be_read_is_left_out_until_the_next_key_packet(served):
    watch, _ = served
    answer = watch()
    assert part(answer) is not None
    for number, key, data in ((2, False, b"garbage"), (3, False, RING[:30]), (4, True, RING)):
        bus.publish_stream("irat", 0, [pack(StreamPacket(0, number, number, key, data))], from_key=key)
    bus.connection().publish(bus.state_channel("irat"), b"\x01")
    bus.connection().publish(bus.frames_channel("irat"), b"\x02")
    seen = [part(answer) for _ in range(10)]
    assert None not in seen


def test_other_names_and_methods_are_answered_in_words(served):
    watch, _ = served
    for path in ("/robots/irat/live/huge.mjpg", "/robots/none/live/desktop.mjpg"):
        assert watch(path).status == 404


CAMERA, NEWEST = "/robots/irat/camera/0.mjpg", "/robots/irat/camera/0.jpg"


def ask(path, method="GET", **headers):
    """Ask in a connection of its own; return the answer, read to its end."""

    def asked(port):
        line = http.client.HTTPConnection("127.0.0.1", port, timeout=15)
        line.request(method, path, headers={"Host": "localhost"} | {k.replace("_", "-"): v for k, v in headers.items()})
        answer = line.getresponse()
        answer.body = answer.read()
        line.close()
        return answer

    return asked


@pytest.mark.asvs("15.2.2")
def test_a_camera_s_own_pictures_are_passed_on_unchanged_to_all(served):
    watch, teller = served
    one, other = watch(CAMERA), watch(CAMERA)
    seen = [part(one) for _ in range(5)], [part(other) for _ in range(5)]
    assert {*seen[0], *seen[1]} == {teller.view}
    assert watch("/robots/irat/camera/1.mjpg").status == 404
    assert watch("/robots/nobody/camera/0.mjpg").status == 404
    leave(one, other)
    wait_for(lambda: not bus.watched("irat", "frames"), 15, "nobody watches any more")


def test_a_stream_begins_at_once_with_the_newest_still_and_the_head_of_the_next_part(served):
    """A browser shows a part when it has read the head of the one after it."""
    watch, teller = served
    teller.stop()  # the camera sends nothing
    still = cv2.imencode(".jpg", np.full((60, 80, 3), 200, np.uint8))[1].tobytes()
    file = settings.MEDIA_ROOT / "frames" / "irat" / "still.jpg"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(still)
    Frame.objects.create(robot=Robot.objects.get(), taken_at=SYSTEM.now(), file="frames/irat/still.jpg")
    answer = watch(CAMERA)
    begun = time.monotonic()
    assert part(answer) == still
    assert time.monotonic() - begun < 4.0, "it does not wait for the next one, nor for the end of the stream"


def test_the_newest_picture_has_an_address_of_its_own_that_caches_may_keep(served):
    watch, teller = served
    port = watch(CAMERA).line.port
    found = ask(NEWEST)(port)
    assert (found.status, found.headers["Cache-Control"]) == (302, "public, max-age=1")
    place = found.headers["Location"]
    at_ms = int(re.fullmatch(r"/robots/irat/camera/0/(\d+)\.jpg", place)[1])
    assert abs(at_ms / 1000 - time.time()) < 5
    shown = ask(place)(port)
    assert (shown.status, shown.headers["Content-Type"], shown.body) == (200, "image/jpeg", teller.view)
    assert "immutable" in shown.headers["Cache-Control"]
    again = ask(place, If_None_Match=shown.headers["ETag"])(port)
    assert (again.status, again.body, again.headers["ETag"]) == (304, b"", shown.headers["ETag"])
    assert ask(place, If_Modified_Since=shown.headers["Last-Modified"])(port).status == 304
    assert ask(place, If_None_Match='"another"')(port).status == 200
    assert (ask(place, "HEAD")(port).status, ask(place, "HEAD")(port).body) == (200, b"")
    wait_for(lambda: ask(NEWEST)(port).headers["Location"] != place, 15, "the next picture has another address")


def test_pictures_that_are_not_there_are_refused_in_a_sentence(served):
    watch, teller = served
    port = watch(CAMERA).line.port
    for path in (
        "/robots/irat/camera/0/1.jpg",
        f"/robots/irat/camera/0/{'9' * 400}.jpg",
        "/robots/irat/camera/7/5.jpg",
    ):
        found = ask(path)(port)
        assert (found.status, found.body) == (404, b"That picture is no longer kept; ask for the newest one.\n")
    assert ask("/robots/irat/camera/9.jpg")(port).status == 404
    assert ask("/robots/nobody/camera/0.jpg")(port).status == 404
    assert ask(NEWEST, "POST")(port).status in (403, 405)
    teller.stop()
    wait_for(lambda: ask(NEWEST)(port).status == 503, 15, "the last one that is known is too old")
    Lease.objects.update(expires_at=SYSTEM.now() - timedelta(seconds=9))
    found = ask(NEWEST)(port)
    assert (found.status, found.headers["Retry-After"]) == (503, "30")
