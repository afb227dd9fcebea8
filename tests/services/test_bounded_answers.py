"""Readers of robots' wires have a bound in length and one deadline for the whole answer; what is too long ends nothing."""

import json
import socket
import threading
from contextlib import contextmanager, suppress

import pytest
from websockets.sync.server import serve

from robots.kit.contract.errors import HardwareFault, LineGone, LineSilent
from robots.kit.drivers import rosbridge_client
from robots.kit.drivers.irat.line import IratLine
from robots.kit.drivers.pa10 import line as arms
from robots.kit.drivers.pa10.line import ArmLine
from robots.kit.drivers.pa10.protocol import Request
from robots.kit.drivers.rosbridge_client import MOST_BYTES, Bridge
from tests.conftest import wait_for


@contextmanager
def rosbridge(talk):
    with serve(talk, "127.0.0.1", 0, max_size=None, close_timeout=0.5) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"127.0.0.1:{server.socket.getsockname()[1]}"
        server.shutdown()
        thread.join(20)


def picture(size):
    data = {"format": "jpeg", "data": "A" * size}
    return json.dumps({"op": "publish", "topic": "/irat/camera/image/compressed", "msg": data})


@pytest.mark.parametrize("size", [MOST_BYTES, 3_000_000, 30_000_000])
def test_a_picture_of_over_a_megabyte_is_left_out_and_the_line_that_drives_goes_on(size):
    def talk(connection):
        for data in connection:
            asked = json.loads(data)
            if asked["op"] == "call_service":
                connection.send(picture(size))
                values = {"success": True, "message": "", "epoch": 5}
                connection.send(
                    json.dumps({"op": "service_response", "id": asked["id"], "values": values, "result": True})
                )

    with rosbridge(talk) as address:
        line = IratLine(address, 5, lambda picture: pytest.fail("it is left out"))
        for seconds in (60.0, 60.0):  # as long as a busy machine needs for so many bytes
            line.bridge.open() if not line.bridge.is_open else None
            assert line.bridge.call("/irat/hold", seconds=seconds)["success"]
        assert line.bridge.is_open
        assert line.bridge.left_out == 2
        line.close()


def test_a_robot_that_reads_nothing_keeps_no_thread(monkeypatch):
    monkeypatch.setattr(rosbridge_client, "SEND_S", 0.2)
    over = threading.Event()
    with rosbridge(lambda connection: over.wait(120)) as address:
        bridge = Bridge(address)
        bridge.open()

        def flood():
            for _ in range(100_000):
                bridge.publish("/x", {"data": "A" * 10_000})

        with pytest.raises(LineGone, match="broke"):
            flood()
        assert not bridge.is_open
        bridge.close()
        over.set()


@pytest.mark.parametrize("said", [b"", b"HTTP/1.1 101 Sw", b"x" * 100_000, b"HTTP/1.1 200 OK\r\n" + b"a: b\r\n" * 5000])
def test_an_opening_has_a_limit(said, monkeypatch):
    monkeypatch.setattr(rosbridge_client, "OPEN_S", 0.3)
    monkeypatch.setattr(arms, "ANSWER_S", 0.3)
    with answering(lambda line: line.sendall(said)) as port:
        with pytest.raises(LineGone):
            Bridge(f"127.0.0.1:{port}").open()
        if said in (b"", b"HTTP/1.1 101 Sw"):
            with pytest.raises(LineSilent):
                ArmLine(f"127.0.0.1:{port}", 1, "", None).open()


@contextmanager
def answering(answer, name=None):
    """Take connections in threads of that name; `answer` gets each, which stays open until the end."""
    server, lines = socket.create_server(("127.0.0.1", 0)), []

    def run():
        while True:
            try:
                line, _ = server.accept()
            except OSError:
                return
            lines.append(line)
            threading.Thread(target=one, args=(line,), daemon=True, name=name).start()

    def one(line):
        with suppress(OSError):
            answer(line)

    threading.Thread(target=run, daemon=True, name=name).start()
    yield server.getsockname()[1]
    server.close()
    for line in lines:
        line.close()


def test_an_arms_answer_byte_by_byte_ends_at_its_deadline(monkeypatch):
    monkeypatch.setattr(arms, "ANSWER_S", 60.0)
    sent, asked = [], threading.Event()

    def dribble(line):
        line.recv(4096)
        line.sendall(b"ok epoch\n")
        line.recv(4096)
        asked.set()
        for _ in range(3000):
            line.sendall(b"x")
            sent.append(1)
            threading.Event().wait(0.02)

    with answering(dribble) as port:
        line = ArmLine(f"127.0.0.1:{port}", 1, "", None)
        line.open()
        with pytest.raises(LineSilent):
            line.ask(Request("w"), seconds=0.5)
        assert asked.is_set()
        assert len(sent) < 3000, "it ended at its deadline, not at the last byte"
        wait_for(lambda: sent, 60, "a byte: it was not silent")
        assert not line.is_open, "an answer that comes later must not be taken for the next one"


def test_an_arms_answer_without_an_end_is_bounded(monkeypatch):
    monkeypatch.setattr(arms, "ANSWER_S", 60.0)

    def pour(line):
        line.recv(4096)
        while True:
            line.sendall(b"x" * 65_536)

    with answering(pour) as port:
        line = ArmLine(f"127.0.0.1:{port}", 1, "", None)
        with pytest.raises(HardwareFault, match="has no end"):
            line.open()
        assert not line.is_open
        assert not line._rest


def test_staff_who_watch_the_wire_do_not_see_the_token(monkeypatch):
    monkeypatch.setattr(arms, "ANSWER_S", 60.0)
    traced, heard = [], []

    def greet(line):
        heard.append(line.recv(4096))
        line.sendall(b"ok epoch\n")

    with answering(greet) as port:
        line = ArmLine(f"127.0.0.1:{port}", 7, "open-sesame", lambda *frame: traced.append(frame))
        line.open()
        line.close()
    assert heard == [b"i 7 open-sesame\n"]
    assert [words for _, _, words in traced] == ["i 7 ***", "ok epoch"]
    assert not any(b"sesame" in data for _, data, _ in traced)


def test_a_bridge_that_is_gone_is_told_at_once():
    with rosbridge(lambda connection: (connection.recv(), connection.close())) as address:
        bridge = Bridge(address)
        bridge.open()
        bridge.publish("/x", {})
        wait_for(lambda: not bridge.is_open, 20, "the end")
        bridge.close()
