"""A hostile socket leaves nothing behind: no viewer, no task, no watch key."""

import json
import socket
from contextlib import ExitStack, suppress

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from benchmarks.command_round_trip import cookie
from portal.edge.limits import AddressRate
from robots import bus
from robots.kit.clock import SYSTEM
from tests.conftest import wait_for
from tests.faults.here import closed, handshake, heard, line

MALFORMED = [
    {"t": "command", "kind": [], "seq": 1}, {"t": "command", "kind": {}, "seq": 1}, {"t": "watch", "cameras": [[]]},
    {"t": [], "seq": {}}, {"t": "plan", "kind": 0, "from": 1}, {"t": "keep", "seq": []}, {"t": "nope"}, {},
]  # fmt: skip


@pytest.mark.timed
@pytest.mark.asvs("1.5.2", "2.2.1")
@pytest.mark.parametrize("said", MALFORMED)
def test_a_malformed_message_is_answered_and_leaves_no_viewer(web, said):
    with line(web) as one:
        heard(one, "snapshot")
        one.send(json.dumps(said))
        answer = heard(one, "answer")
        assert not answer["ok"]
        assert "not understood" in answer["text"]
        one.send('{"t": "ping", "n": 3}')
        assert heard(one, "pong")["n"] == 3
        assert web.left()["viewers"] == 1
    web.nothing_left()


@pytest.mark.timed
@pytest.mark.parametrize("said", ["", "{", "[]", "[" * 3000, b"\x00\x01", "x" * 9000, '{"t":"ping","n":NaN}'])
def test_what_no_page_sends_closes_the_socket(web, said):
    with line(web) as one:
        heard(one, "snapshot")
        one.send(said)
        assert closed(one)[0] == 4400
    web.nothing_left()


@pytest.mark.timed
@pytest.mark.asvs("1.5.2", "2.2.1")
def test_a_burst_closes_the_socket_once(web):
    with line(web) as one:
        heard(one, "snapshot")
        with suppress(ConnectionClosed):  # while it still sends
            for n in range(150):
                one.send(json.dumps({"t": "ping", "n": n}))
        assert closed(one)[0] == 4429
    web.nothing_left()


@pytest.mark.timed
@pytest.mark.asvs("2.4.1")
def test_sockets_of_one_address_that_keep_just_within_their_own_limit_are_ended_and_a_calm_one_stays(web, monkeypatch):
    monkeypatch.setattr("portal.live.socket.OF_ADDRESS", AddressRate(5.0, 60.0))
    with line(web) as calm, ExitStack() as stack:
        floods = [stack.enter_context(line(web, max_queue=None)) for _ in range(4)]
        for one in (calm, *floods):
            heard(one, "snapshot")
        open_now, rounds = set(floods), 0
        while open_now and (rounds := rounds + 1) < 500:
            for one in list(open_now):
                try:
                    one.send('{"t": "join"}')
                except ConnectionClosed:
                    open_now.discard(one)
            SYSTEM.sleep(1 / 25)
        assert [closed(one)[0] for one in floods] == [4429] * 4
        for n in range(3):
            calm.send(json.dumps({"t": "ping", "n": n}))
            assert heard(calm, "pong")["n"] == n


@pytest.mark.timed
def test_a_stranger_is_told_to_sign_in_and_costs_no_thread(web, monkeypatch):
    def never(*_):
        raise AssertionError("a thread")

    with line(web) as one:
        heard(one, "snapshot")
        monkeypatch.setattr("portal.live.robot_socket.act", never)
        for asked in ({"t": "join"}, {"t": "stop"}, {"t": "command", "kind": "noop", "args": {}, "seq": 1}):
            one.send(json.dumps(asked))
            answer = heard(one, "answer")
            assert (answer["ok"], answer["code"], answer["to"]) == (False, "signed_out", asked["t"])


@pytest.mark.timed
def test_frames_sent_before_the_handshake_is_answered_end_the_connection(web, caplog):
    """RFC 6455, 4.1: a client waits for the answer. What came too early once ended in an assertion of uvicorn."""
    for early in (b"\x83\x80\0\0\0\0", b"\x89\x80\0\0\0\0", b"\x88\x80\0\0\0\0", b"\xff" * 30):
        for n in range(20):
            with socket.create_connection(("127.0.0.1", web.port), timeout=20) as one:
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                one.sendall(handshake(web))
                SYSTEM.sleep(n / 5000)
                one.sendall(early)
    web.nothing_left()
    assert not [r for r in caplog.records if r.levelname == "ERROR"], caplog.text


def test_a_refused_socket_is_answered_and_writes_no_error(web, caplog):
    refused = [
        (handshake(web, "/ws/nowhere/"), 404), (handshake(web).replace(b"Origin: http://localhost", b"Origin: http://evil"), 403),
        (handshake(web).replace(b"Host: localhost", b"Host: evil.example"), 403), (handshake(web, "/ws/me/"), None),
        (handshake(web, "/ws/robots/nothing/"), None), (handshake(web, "/ws/operators/mercury/"), None),
    ]  # fmt: skip
    for sent, status in refused:
        with socket.create_connection(("127.0.0.1", web.port), timeout=120) as one:
            one.sendall(sent)
            answer = one.recv(4000)
            assert answer.startswith(b"HTTP/1.1 "), sent
            assert status is None or answer.startswith(b"HTTP/1.1 %d " % status), answer
            if status is not None:
                while one.recv(4000):  # it ends by itself
                    pass
    web.nothing_left()
    assert not [r for r in caplog.records if r.levelname in ("ERROR", "CRITICAL")], caplog.text


@pytest.mark.timed
def test_an_address_that_is_too_long_is_refused_and_not_left_waiting(web):
    with socket.create_connection(("127.0.0.1", web.port), timeout=5) as one:
        one.sendall(handshake(web, path=f"/ws/robots/mercury/?watch={'x' * 9000}"))
        assert one.recv(1000).startswith(b"HTTP/1.1 400 ")
        assert not one.recv(1000)
    web.nothing_left()


@pytest.mark.timed
def test_the_watch_keys_end_with_the_last_viewer(web):
    with line(web) as one:
        heard(one, "snapshot")
        wait_for(lambda: bus.watched("mercury"), 5, "the watch key")
    web.nothing_left()
    wait_for(lambda: not bus.connection().keys("farhand:*:watch:*"), bus.WATCH_S + 1, "the end of the watch keys")


@pytest.mark.timed
@pytest.mark.asvs("1.5.2", "2.2.1")
def test_a_line_cut_anywhere_leaves_nothing(web, people):
    head = (
        f"GET /ws/robots/mercury/ HTTP/1.1\r\nHost: localhost:{web.port}\r\nOrigin: http://localhost:{web.port}\r\n"
        f"Cookie: {cookie(people['ada'])}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    ).encode()
    frame = b"\x81\x8e\x00\x00\x00\x00" + b'{"t": "ping"}\n'  # a whole text frame, mask of zeros
    said = head + frame * 2
    for end in [*range(0, len(head), 37), *range(len(head), len(said) + 1)]:
        with socket.create_connection(("127.0.0.1", web.port)) as raw:
            raw.sendall(said[:end])
            if end % 2:
                SYSTEM.sleep(0.02)
    web.nothing_left()


@pytest.mark.timed
def test_a_robot_that_is_not_there_closes_with_its_code(web):
    with line(web, path="/ws/robots/nobody/") as one:
        assert closed(one)[0] == 4404
    web.nothing_left()


def refusal(web, path="/ws/robots/mercury/", **more):
    from websockets.exceptions import InvalidStatus

    with pytest.raises(InvalidStatus) as refused:
        connect(f"ws://127.0.0.1:{web.port}{path}", **more)
    return refused.value.response.status_code


@pytest.mark.timed
@pytest.mark.asvs("8.2.1")
def test_an_unknown_address_of_a_socket_is_answered(web):
    own = f"http://127.0.0.1:{web.port}"
    for path in (
        "/",
        "/ws/",
        "/ws/robots/",
        "/ws/robots/a/b/",
        "/ws/robots/%00/",
        "/ws/robots/mercury",
        "/%ff",
        "/ws/robots/²/",
    ):
        assert refusal(web, path.encode("ascii", "ignore").decode(), origin=own) == 404
    web.nothing_left()


@pytest.mark.timed
@pytest.mark.asvs("4.4.2")
def test_promise_33_foreign_null_and_missing_origins_are_refused(web, proof):
    own = f"127.0.0.1:{web.port}"
    strange = [
        None, "null", "http://evil.example", f"https://{own}", f"http://localhost:{web.port}", "http://127.0.0.1",
        f"http://127.0.0.1:{web.port + 1}", f"http://{own}.evil.example", f"http://{own}@evil.example", f"http://{own}/",
        "file://", f"ws://{own}",
    ]  # fmt: skip
    for origin in strange[: proof.count("origins", 12, 12)]:
        assert refusal(web, origin=origin) == 403
    with connect(f"ws://{own}/ws/robots/mercury/", origin=f"http://{own}") as one:
        heard(one, "snapshot")
    web.nothing_left()
    proof.holds("12 of 12 refused with 403, the site's own taken")
