"""Unfinished, oversized, excessive or unread requests end at the real web process, over raw connections."""

import contextlib
import re
import select
import socket
import struct
import time
import urllib.request
from collections import Counter
from pathlib import Path

import pytest
from django.conf import settings

from benchmarks.command_round_trip import cookie
from portal.edge.protocols import PIPELINED
from robots import bus
from tests.conftest import wait_for
from tests.rig import Web

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

HEAD_S, BODY_S = 1.5, 1.5
LARGEST = max((Path(settings.FRONTEND_DIST) / "assets").glob("*.js"), key=lambda file: file.stat().st_size)
OPEN = []  # connections that a test has opened; closed at its end
GET = b"GET /livez HTTP/1.1\r\nHost: localhost\r\n"
POST = b"POST /accounts/login/ HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/x-www-form-urlencoded\r\n"
UPGRADE = b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"


@pytest.fixture
def start(transactional_db, redis_server, robot, people):
    bus.connection().flushall()
    made = []

    def web(**env):
        limits = {"FARHAND_HEAD_S": str(HEAD_S), "FARHAND_BODY_S": str(BODY_S), "FARHAND_READ_S": "2"}
        made.append(Web(**limits | env))
        return made[-1]

    yield web
    while OPEN:
        OPEN.pop().close()
    for one in made:
        assert one.alive(), one.said()
        assert "Traceback" not in one.said()
        one.kill()


def raw(web, said=b"", source="127.0.0.1"):
    one = socket.create_connection(("127.0.0.1", web.port), timeout=10, source_address=(source, 0))
    OPEN.append(one)
    one.sendall(said)
    return one


def ended(one, seconds=15):
    """Read to the end of a connection; return the received bytes."""
    said, until = b"", time.monotonic() + seconds
    with one, contextlib.suppress(ConnectionError):
        while True:
            one.settimeout(max(0.01, until - time.monotonic()))
            part = one.recv(65536)
            if not part:
                break
            said += part
    return said


def handshake(web, path="/ws/robots/mercury/", source="127.0.0.1", who=None):
    more = f"Cookie: {cookie(who)}\r\n" if who else ""
    head = (
        f"GET {path} HTTP/1.1\r\nHost: localhost:{web.port}\r\nOrigin: http://localhost:{web.port}\r\n{more}".encode()
    )
    one = raw(web, head + UPGRADE + b"\r\n", source)
    answer = b""
    while b"\r\n\r\n" not in answer:
        answer += one.recv(1)
    status = int(answer.split()[1])
    if status != 101:
        one.close()
    return one, status


def serves(web):
    with urllib.request.urlopen(f"{web.url}/status/", timeout=10) as answer:
        return answer.status == 200


def descriptors(web):
    return len(list(Path(f"/proc/{web.pid}/fd").iterdir()))


def open_now(web):
    """Return how many sockets and files of the front end the process has open."""
    found = Counter()
    for entry in Path(f"/proc/{web.pid}/fd").iterdir():
        with contextlib.suppress(OSError):  # closed meanwhile
            told = str(entry.readlink())
            found["sockets"] += told.startswith("socket:")
            found["answers"] += "/assets/" in told
    return found


def written_mb(web):
    """Return what the process has written, to files and sockets, ever."""
    return int(re.search(r"wchar: (\d+)", Path(f"/proc/{web.pid}/io").read_text())[1]) / 1e6


def memory_mb(web):
    status = Path(f"/proc/{web.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024


HALVES = {
    "nothing": b"", "a line": b"GET / HTTP/1.1\r\n", "a head": GET + b"X-A: b\r\n", "empty lines": b"\r\n\r\n\r\n",
    "a body": POST + b"Content-Length: 1000\r\n\r\nlogin=", "a chunk": POST + b"Transfer-Encoding: chunked\r\n\r\n40\r\nabc",
    "an answer first": GET + b"\r\n" + b"GET /livez HT",
}  # fmt: skip


@pytest.mark.asvs("15.2.2")
def test_three_hundred_half_sent_requests_do_not_stay_open(start):
    web = start()
    before = descriptors(web)
    said = list(HALVES.values())
    held = [raw(web, said[n % len(said)]) for n in range(300)]
    assert serves(web)
    for one in held:
        ended(one)
    wait_for(lambda: descriptors(web) <= before + 5, 10, "their end")


def trickle(one, piece):
    """Send a piece again and again until something is answered; return the received bytes."""
    begun = time.monotonic()
    with contextlib.suppress(OSError):
        while time.monotonic() - begun < 15:
            one.sendall(piece)
            if select.select([one], [], [], 0.1)[0]:
                break
    return ended(one)


@pytest.mark.asvs("15.2.2")
def test_a_head_that_trickles_ends(start):
    assert b"408" in trickle(raw(start(), GET), b"X-A: b\r\n")


@pytest.mark.asvs("15.2.2")
def test_a_body_that_trickles_ends(start):
    assert b" 408 " in trickle(raw(start(), POST + b"Content-Length: 200000\r\n\r\n"), b"x")


@pytest.mark.asvs("5.2.1")
@pytest.mark.parametrize(
    ("head", "status"),
    [(b"Content-Length: 314572800\r\n\r\n", b" 413 "), (b"Content-Length: 9999999999999999999\r\n\r\n", b" 4"),
     (b"Transfer-Encoding: chunked\r\n\r\n", b" 413 ")],
)  # fmt: skip
def test_a_body_of_300_mib_is_refused_before_it_is_stored(start, head, status):
    web = start()
    memory, wrote = memory_mb(web), written_mb(web)
    one = raw(web, POST + head)
    sent = 0
    chunk = b"10000\r\n" + b"x" * 65536 + b"\r\n" if b"chunked" in head else b"x" * 65536
    with contextlib.suppress(OSError):
        while sent < 300 * 2**20 and not select.select([one], [], [], 0)[0]:
            sent += one.send(chunk)
    assert sent < 8 * 2**20
    answer = b""
    with contextlib.suppress(OSError):  # unread data resets the connection
        answer = ended(one)
    assert not answer or status in answer.split(b"\r\n")[0] + b" "
    assert memory_mb(web) - memory < 20
    assert written_mb(web) - wrote < 20
    assert serves(web)


@pytest.mark.asvs("15.2.2")
def test_an_endless_head_is_refused(start):
    web = start()
    memory = memory_mb(web)
    one, sent = raw(web, GET), 0
    with contextlib.suppress(OSError):
        while sent < 50 * 2**20 and not select.select([one], [], [], 0)[0]:
            sent += one.send(b"X-A: " + b"b" * 8000 + b"\r\n")
    assert sent < 4 * 2**20
    assert memory_mb(web) - memory < 20
    ended(one)
    assert serves(web)


def ping(data=b"x" * 125):
    return struct.pack("!BB4s", 0x89, 0x80 | len(data), b"\0\0\0\0") + data


@pytest.mark.asvs("15.2.2")
@pytest.mark.parametrize(
    "what", [ping(), struct.pack("!BB4s", 0x8A, 0x80, b"\0\0\0\0"), struct.pack("!BB4s", 0x00, 0x80, b"\0\0\0\0")]
)
def test_a_flood_of_frames_at_a_socket_that_never_reads_ends_it(start, what):
    web = start()
    memory = memory_mb(web)
    one, status = handshake(web)
    assert status == 101
    if what[0] == 0:  # pieces belong to a message that has begun
        one.sendall(struct.pack("!BB4s", 0x01, 0x80, b"\0\0\0\0"))
    sent = 0
    with contextlib.suppress(OSError):
        while sent < 40 * 2**20:
            sent += one.send(what * 200)
    assert sent < 40 * 2**20
    one.close()
    assert memory_mb(web) - memory < 20
    assert serves(web)


@pytest.mark.asvs("15.2.2")
@pytest.mark.parametrize("many", [6, PIPELINED])
def test_what_is_never_read_does_not_stay_open(start, many):
    """Also with more requests behind the one whose answer is not taken."""
    web = start()
    before, written = open_now(web), written_mb(web)
    held = []
    for _ in range(20):
        one = socket.socket()
        OPEN.append(one)
        one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        one.connect(("127.0.0.1", web.port))
        one.sendall(f"GET /static/app/assets/{LARGEST.name} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode() * many)
        held.append(one)
    wait_for(lambda: written_mb(web) > written + 20 * LARGEST.stat().st_size / 1e6, 20, "all are served")
    wait_for(lambda: open_now(web)["sockets"] <= before["sockets"], 40, "their end")
    wait_for(lambda: open_now(web)["answers"] <= before["answers"], 10, "the end of what was read for them")
    assert serves(web)


def test_what_is_read_slowly_is_read_to_its_end(start):
    """More slowly than a buffer is emptied within the limit; what is limited is to take nothing."""
    many, size = PIPELINED, LARGEST.stat().st_size  # more than the system takes over at once
    web = start(FARHAND_READ_S="3")
    one = socket.socket()
    OPEN.append(one)
    one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65536)
    one.connect(("127.0.0.1", web.port))
    one.sendall(f"GET /static/app/assets/{LARGEST.name} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode() * many)
    begun, taken = time.monotonic(), 0
    while time.monotonic() - begun < 10.0:
        time.sleep(0.2)
        taken += len(one.recv(20_000))
    assert taken + len(ended(one, 30)) > many * size


@pytest.mark.asvs("2.4.1")
def test_one_address_has_so_many_sockets_and_the_next_address_its_own(start):
    web = start(FARHAND_SOCKETS_PER_ADDRESS="5")
    mine = [handshake(web) for _ in range(5)]
    assert [status for _, status in mine] == [101] * 5
    assert handshake(web)[1] == 429
    other, status = handshake(web, source="127.0.0.2")
    assert status == 101
    mine[0][0].close()
    later = wait_for(
        lambda: next((one for one, status in [handshake(web)] if status == 101), None), 5, "room for another"
    )
    for one in (*(one for one, _ in mine), other, later):
        one.close()
    assert serves(web)


@pytest.mark.asvs("2.4.1")
def test_one_address_has_so_many_requests_and_connections_at_once(start):
    web = start(FARHAND_REQUESTS_PER_ADDRESS="4", FARHAND_CONNECTIONS_PER_ADDRESS="8", FARHAND_BODY_S="8")
    half = POST + b"Content-Length: 1000\r\n\r\nlogin="

    def hold():
        """Begin a request that waits for its body; None where the web process's first request still counts."""
        one = raw(web, half)
        answered, _, _ = select.select([one], [], [], 0.3)
        return None if answered else one

    held = [wait_for(hold, 5, "room for a request") for _ in range(4)]
    assert b" 429 " in ended(raw(web, GET + b"Connection: close\r\n\r\n"))
    assert b" 200 " in ended(raw(web, GET + b"Connection: close\r\n\r\n", source="127.0.0.3"))
    idle = [raw(web) for _ in range(8)]
    said = [ended(one) for one in idle]
    assert sum(b" 503 " in one for one in said) >= 4
    for one in held:
        assert b" 408 " in ended(one)
    wait_for(lambda: serves(web), 5, "room")


def test_a_school_class_behind_one_address_is_served(start, people):
    web = start()
    sockets = [handshake(web, path) for _ in range(150) for path in ("/ws/robots/mercury/", "/ws/robots/mercury/")]
    assert {status for _, status in sockets} == {101}
    assert serves(web)
    for one, _ in sockets:
        one.close()
