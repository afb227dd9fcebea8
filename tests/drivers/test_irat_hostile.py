"""Bad input on the iRat's wire: a sentence is the answer, nothing moves, and nobody else notices."""

import contextlib
import json
import socket
import time

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from tests.conftest import wait_for
from tests.drivers.irat_wire import EPOCHS, WireClient, framed, journal

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


def velocity(**more):
    return json.dumps({"op": "publish", "topic": "/irat/cmd_vel", "msg": more})


def stamped(seconds, twist, epoch=7):
    message = {"epoch": epoch, "sec": seconds, "twist": twist}
    return json.dumps({"op": "publish", "topic": "/irat/drive", "msg": message})


BAD = {
    "": "not JSON",
    "{": "not JSON",
    '{"op": "publish", "topic": "/irat/cmd_vel", "msg": {"linear": {"x"': "not JSON",
    "[" * 5000: "not JSON",
    "7": "one JSON object",
    "null": "one JSON object",
    "{}": "there is no op",
    '{"op": 3}': "there is no op",
    '{"op": "fragment", "data": "x", "num": 0, "total": 2}': "is not spoken here",
    '{"op": "__class__"}': "is not spoken here",
    '{"op": "leave"}': "is not spoken here",
    '{"op": "subscribe"}': "topic must be a text",
    '{"op": "subscribe", "topic": "/nothing"}': "there is no topic /nothing",
    '{"op": "subscribe", "topic": "../../etc"}': "is not a name",
    '{"op": "subscribe", "topic": "/irat/odom", "type": "std_msgs/String"}': "has the type nav_msgs/Odometry",
    '{"op": "subscribe", "topic": "/irat/odom", "compression": "cbor"}': "compression is not spoken here",
    '{"op": "subscribe", "topic": "/irat/odom", "throttle_rate": -1}': "throttle_rate is -1",
    '{"op": "subscribe", "topic": "/irat/odom", "id": [1]}': "an id is a text",
    '{"op": "advertise", "topic": "/irat/odom"}': "the robot's own",
    '{"op": "publish", "topic": "/irat/cmd_vel", "msg": 5}': "must be an object",
    velocity(linear=5): "linear must be an object",
    velocity(linear={"x": "fast"}): "x must be a number",
    velocity(linear={"x": True}): "x must be a number",
    velocity(linear={"x": None}): "x must be a number",
    velocity(linear={"x": 0.21}): "x is 0.21; it must be from -0.2 to 0.2 m/s",
    velocity(linear={"x": 1e308}): "x is 1e+308",
    velocity(linear={"y": 0.1}): "two wheels",
    velocity(angular={"z": -2.6}): "z is -2.6; it must be from -2.5 to 2.5 rad/s",
    velocity(linear={"x": float("nan")}): "x must be a number",
    stamped(0, {"linear": {"x": 0.1}}): "epoch 7 does not command",
    stamped(0, {"linear": {"x": 0.1}}, "7"): "epoch must be a number",
    stamped(0, {"linear": {"x": 0.1}}, 0.5): "epoch is 0.5",
    stamped(0, {"linear": {"x": 0.1}}, 10**400): "epoch is an integer of 401 digits",
    stamped(1e308, {"linear": {"x": 0.1}}): "sec is 1e+308",
    stamped("now", {"linear": {"x": 0.1}}): "sec must be a number",
    stamped(0, 5): "twist must be an object",
    velocity(linear={"x": float("inf")}): "x must be a number",
    '{"op": "publish", "topic": "/irat/cmd_vel", "msg": {"linear": {"x": 1e999}}}': "x must be a number",
    '{"op": "publish", "topic": "/irat/cmd_vel", "msg": {"linear": {"x": ' + "9" * 400 + "}}}": "x is an integer of 400 digits",
}  # fmt: skip


@pytest.mark.parametrize("frame", BAD, ids=lambda frame: frame[:50])
def test_a_sentence_is_the_answer_and_nothing_moves(irat, wire_client, frame):
    wire_client.claim()
    wire_client.send(frame)
    said = wire_client.complaint()
    assert BAD[frame] in said
    assert irat.count("motion") == irat.count("crash") == 0
    assert wire_client.status()["moving"] is False, "and the connection goes on"


@pytest.mark.parametrize("epoch", [0, -1, 1.5, True, None, "7", [], 2**53, 1e300, {"a": 1}])
def test_an_epoch_is_a_whole_number(irat, wire_client, epoch):
    answer = wire_client.call("/irat/claim", epoch=epoch)
    assert answer["result"] is False
    assert "epoch" in answer["values"]
    assert irat.status()["epoch"] == 0


def test_binary_frames_and_frames_that_are_too_long(irat, wire_client):
    wire_client.send(b"\x00\xff{}")
    assert "binary" in wire_client.complaint()
    wire_client.send(velocity(linear={"x": 0.0}, pad="x" * 20_000))
    with pytest.raises(ConnectionClosed):
        wire_client.complaint()
    assert WireClient(irat).status()["moving"] is False


def test_a_message_in_pieces_is_one_message(irat, wire_client):
    wire_client.claim()
    wire_client.line.send(iter(['{"op": "publish", "topic": "/irat/cmd_vel", ', '"msg": {"angular"', ': {"z": 0.5}}}']))
    wait_for(lambda: irat.count("motion"), 3, "the motion")


def test_half_a_frame_is_no_command(irat):
    wire_client = WireClient(irat)
    wire_client.claim()
    frame = framed(velocity(linear={"x": 0.1}))
    wire_client.line.socket.sendall(frame[: len(frame) // 2])
    time.sleep(0.2)
    wire_client.line.socket.shutdown(socket.SHUT_WR)
    wait_for(lambda: irat.count("disconnected"), 10, "the end of the connection")
    assert irat.count("motion") == 0
    assert WireClient(irat).claim()["success"], "nobody is locked out"


def test_pages_in_a_browser_are_not_served(irat):
    with pytest.raises(InvalidStatus) as refused:
        WireClient(irat, origin="https://evil.example")
    assert refused.value.response.status_code == 403


def test_garbage_instead_of_a_handshake(irat):
    host, port = irat.address.removeprefix("ws://").split(":")
    for garbage in (
        b"\x00" * 100,
        b"GET / HTTP/1.1\r\n\r\n",
        b"SSH-2.0-x\r\n",
        b"GET /" + b"a" * 9000,
        b"\x16\x03\x01",
    ):
        with socket.create_connection((host, int(port)), timeout=5) as line:
            line.sendall(garbage)
            line.shutdown(socket.SHUT_WR)
            with contextlib.suppress(ConnectionResetError):
                line.recv(4096)
    assert WireClient(irat).status()["moving"] is False
    assert irat.count("crash") == irat.count("thread_died") == 0


def test_a_hundred_silent_sockets_lock_nobody_out(irat, wire_client):
    wire_client.claim()
    host, port = irat.address.removeprefix("ws://").split(":")
    with contextlib.ExitStack() as stack:
        for _ in range(100):
            stack.enter_context(socket.create_connection((host, int(port)), timeout=5))
        assert WireClient(irat).status()["moving"] is False
        wire_client.drive(angular=0.5)
        wait_for(lambda: irat.count("motion"), 3, "the commander, who was there before")


def test_the_commander_stays_while_forty_others_come(irat, wire_client):
    wire_client.claim()
    others = [WireClient(irat) for _ in range(40)]
    assert others[-1].status()["moving"] is False
    wire_client.drive(angular=0.5)
    wait_for(lambda: irat.count("motion"), 3, "the motion")


def test_a_flood_delays_nobody_elses_hold(irat, wire_client):
    wire_client.claim()
    wire_client.drive(linear=0.1)
    flood = WireClient(irat)
    with contextlib.suppress(ConnectionClosed):  # a client that does not read the answers is disconnected
        for _ in range(3000):
            flood.drive(linear=0.1)
    began = time.monotonic()
    assert wire_client.call("/irat/hold")["values"]["success"]
    assert time.monotonic() - began < 1.5
    assert all(record["epoch"] for record in journal(irat, "motion"))


def test_who_does_not_read_holds_nobody_up(irat, wire_client):
    slow = WireClient(irat)
    slow.line.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    slow.say("subscribe", topic="/irat/camera/image/compressed")
    wire_client.say("subscribe", topic="/irat/odom")
    began = time.monotonic()
    for _ in range(20):
        wire_client.hear(lambda f: f["op"] == "publish")
    assert time.monotonic() - began < 10


def test_the_next_owner_is_not_locked_out_by_a_huge_epoch(irat, wire_client):
    """An epoch excludes older ones only until its robot has lost its power or its owner for a minute."""
    assert wire_client.claim(2**53 - 1)["success"]
    assert "is over" in WireClient(irat).claim(next(EPOCHS))["message"]
    boot = irat.status()["boot"]
    irat.fault("restart", count=1)
    wait_for(lambda: irat.status()["boot"] != boot, 3, "the restart")
    assert WireClient(irat).claim(next(EPOCHS))["success"]
