"""Any error of the libraries of wires and microphones means that the wire is lost; it is opened again."""

import os
import threading
import tty

import pytest
from websockets.sync.server import serve

from robots.kit.contract.errors import HardwareFault
from robots.kit.drivers.mercury import protocol
from robots.kit.drivers.pa10.driver import Driver as ArmDriver
from robots.kit.drivers.rosbridge_client import Bridge
from robots.kit.drivers.serial_line import SerialLine
from tests.raised import ORDINARY, name
from workers.door import GuardedSession
from workers.media import sound as sounds
from workers.media.microphone import MicrophoneFault


@pytest.mark.parametrize("error", ORDINARY, ids=name)
def test_a_serial_port_that_cannot_be_opened_written_or_read_is_gone(error, monkeypatch):
    import serial

    class Port:
        in_waiting = 0
        write_fails = reading = False

        def read(self, _):
            if self.reading:
                raise error
            threading.Event().wait(0.001)
            return b""

        def write(self, _):
            raise error

        def close(self):
            raise error

        cancel_read = fileno = close

    def refuse(*_, **__):
        raise error

    line = SerialLine(protocol, "/dev/ttyX", protocol.BAUD, 1, None)
    monkeypatch.setattr(serial, "serial_for_url", refuse)
    with pytest.raises(HardwareFault):
        line.open()
    port = Port()
    monkeypatch.setattr(serial, "serial_for_url", lambda *_, **__: port)
    line.open()
    with pytest.raises(HardwareFault, match="gone"):
        line.status()
    line.close()
    port.reading = True
    line.open()
    line._reader.join(60)
    with pytest.raises(HardwareFault, match="gone"):
        line.status()
    line.close()


@pytest.mark.parametrize("kind", ["line", "rosbridge"])
def test_a_wire_that_got_no_thread_is_opened_again(kind, monkeypatch):
    host, own = os.openpty()
    tty.setraw(own)
    real, full = threading.Thread.start, [True]

    def start(thread):
        if full[0] and thread.name == kind:
            raise RuntimeError("can't start new thread")
        real(thread)

    with serve(lambda line: line.recv(), "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever).start()
        monkeypatch.setattr(threading.Thread, "start", start)
        at = f"127.0.0.1:{server.socket.getsockname()[1]}"
        wire = SerialLine(protocol, os.ttyname(own), protocol.BAUD, 1, None) if kind == "line" else Bridge(at)
        with pytest.raises(RuntimeError):
            wire.open()
        full[0] = False
        wire.open()
        wire.close()
        wire.open()
        wire.close()
        server.shutdown()
    os.close(host)
    os.close(own)


@pytest.mark.parametrize("error", ORDINARY, ids=name)
def test_an_arm_whose_network_fails_is_gone(error, monkeypatch):
    def refuse(*_, **__):
        raise error

    monkeypatch.setattr("socket.create_connection", refuse)
    session = GuardedSession(lambda: ArmDriver("127.0.0.1:9", {"epoch": 1}))
    with pytest.raises(HardwareFault) as told:
        session.connect()
    assert "S3cret" not in str(told.value)


def test_a_message_that_cannot_be_used_ends_no_connection():
    heard, bridge = iter(ORDINARY), Bridge("127.0.0.1:9")

    def fail(message):
        raise next(heard)

    bridge._heard["/x"] = "x/Y", fail, 0.0
    bridge._read(['{"op": "publish", "topic": "/x", "msg": {}}'] * len(ORDINARY))
    assert bridge.unreadable == len(ORDINARY)
    assert next(heard, None) is None


@pytest.mark.django_db
def test_a_microphone_tells_it_to_those_who_listen(robot, clock, monkeypatch):
    told = []
    made = sounds.Sound(robot.slug, clock)
    monkeypatch.setattr(made, "_fail", lambda robot, text: told.append(text))
    for error in (*ORDINARY, MicrophoneFault("It is silent.")):

        def refuse(*_, error=error):
            raise error

        monkeypatch.setattr(sounds, "Microphone", refuse)
        made._try(robot)
    assert told == [sounds.OURS] * len(ORDINARY) + ["It is silent."]
