"""The host keeps the port open while it waits for a controller that boots whenever its port is opened."""

import contextlib
import errno
import os
import pty
import select
import socket
import struct
import termios
import threading
import tty

import pytest

from robots.kit.clock import FasterTimer
from robots.kit.contract.errors import LineGone, LineSilent
from robots.kit.drivers import serial_line as lines
from robots.kit.drivers.mercury import protocol
from robots.kit.drivers.mercury import protocol as wire
from robots.kit.drivers.mercury.driver import Driver
from robots.kit.drivers.serial_line import SerialLine
from robots.models import Grant, Robot
from tests.conftest import FakeClock, wait_for
from tests.drivers.mercury_wire import STATE, floats, frame
from tests.services.owner import made_owner
from workers.door import GuardedSession
from workers.housekeeping import probe

PACE = 4  # times real time: the pace at which the host waits
BOOT, SLOW = struct.pack("<I", 7), 25  # questions that are lost while it boots: one attempt asks 11 times


class Booting:
    """A controller behind a pty, which hears nothing of the first `SLOW` questions after each opening of its port."""

    def __init__(self):
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        os.close(slave)
        self.opened, self.asked, self.looks, self.over = 0, 0, 0, threading.Event()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self):
        poll, closed, receiver = select.poll(), True, None
        poll.register(self.master, select.POLLIN)
        while not self.over.wait(0.001):
            hung_up = any(events & select.POLLHUP for _, events in poll.poll(0))
            if closed and not hung_up:
                self.opened, self.asked, receiver = self.opened + 1, 0, wire.Receiver(wire.INSTRUCTIONS)
            closed, self.looks = hung_up, self.looks + 1
            if closed or not poll.poll(5):
                continue
            try:
                data = os.read(self.master, 4096)
            except OSError as error:
                assert error.errno == errno.EIO  # closed at this moment
                continue
            for one in receiver.feed(data, 0.0):
                self.asked += 1
                if self.asked > SLOW:
                    os.write(self.master, answer(one.seq))

    def look(self):
        """Return once it has seen whether its port is open now."""
        seen = self.looks
        wait_for(lambda: self.looks > seen + 1, 20, "the controller")

    def close(self):
        self.over.set()
        self.thread.join(10)
        os.close(self.master)


class BootingServer:
    """The same controller behind a serial server, which resets it at each connection."""

    def __init__(self):
        self.opened, self.asked = 0, 0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.path = f"socket://127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        with contextlib.suppress(OSError):  # closed
            while True:
                self.connection, _ = self.listener.accept()
                self.opened, self.asked = self.opened + 1, 0
                with self.connection, contextlib.suppress(OSError):
                    self._serve(self.connection)

    def _serve(self, connection):
        receiver = wire.Receiver(wire.INSTRUCTIONS)
        while data := connection.recv(4096):
            for one in receiver.feed(data, 0.0):
                self.asked += 1
                if self.asked > SLOW:
                    connection.sendall(answer(one.seq))

    def look(self):
        """Return once it has seen the first connection; more are counted when they are made."""
        wait_for(lambda: self.opened, 20, "the connection")

    def close(self):
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()


def answer(seq):
    return frame(STATE, seq, BOOT + bytes((0, 0, 0)) + floats(50.0, 100.0, 75.0, 0.0))


class Fast(Driver):
    clock = FasterTimer(PACE)


@pytest.fixture(params=[Booting, BootingServer], ids=["serial", "tcp"])
def booting(request):
    made = request.param()
    yield made
    made.close()


@pytest.mark.service
@pytest.mark.django_db(transaction=True)
def test_an_owner_waits_for_it_and_does_not_open_its_port_again(booting, robot, people):
    owner = made_owner(robot, people)
    Grant.objects.update(ended_at=owner.clock.now())
    owner.owned.driver = GuardedSession(lambda: Fast(booting.path, {}))
    owner.connection.begin()
    assert Robot.objects.get().reason == "The robot did not answer 11 tries on its serial line."
    for _ in range(4):
        if not owner.connection.connected:
            booting.look()
            owner.clock.go(5.0)
            owner.connection.mend()
    assert owner.connection.connected
    booting.look()
    assert booting.opened == 1
    owner.owned.driver.close()


@pytest.mark.django_db
def test_a_test_by_staff_waits_for_it(booting, robot, monkeypatch):
    monkeypatch.setattr(probe, "open_session", lambda *given: Fast(booting.path, {}))
    monkeypatch.setattr("robots.kit.addresses.check_robot_now", lambda address: None)
    Robot.objects.update(address="tcp:127.0.0.1:9", camera="http://127.0.0.1:9/a.jpg")
    assert probe.probe(Robot.objects.get())["connection"] == "ok"
    assert booting.opened == 1


@pytest.mark.parametrize("booting", [Booting], indirect=True)
def test_closing_the_port_leaves_dtr_on(booting):
    port = os.open(booting.path, os.O_RDWR | os.O_NOCTTY)
    settings = termios.tcgetattr(port)
    settings[2] |= termios.HUPCL
    termios.tcsetattr(port, termios.TCSANOW, settings)
    line = SerialLine(protocol, booting.path, protocol.BAUD, 0, None, FasterTimer(PACE))
    line.open()
    assert not termios.tcgetattr(port)[2] & termios.HUPCL
    line.close()
    os.close(port)


def test_a_port_is_opened_again_after_long_silence_or_once_it_is_gone(booting):
    class Clock(FakeClock):
        def wait(self, what, seconds):
            self.sleep(seconds)
            return False

    clock = Clock()
    line = SerialLine(protocol, booting.path, protocol.BAUD, 0, None, clock)
    line.open()
    wait_for(lambda: booting.opened == 1, 20, "the opening")
    port = line._port
    for _ in range(3):
        with pytest.raises(LineSilent):
            line.status()
        line.open()
        assert line._port is port
    clock.go(lines.REOPEN_S)
    line.open()
    assert line._port is not port
    line._lose("pulled")
    port = line._port
    with pytest.raises(LineGone):
        line.status()
    line.open()
    assert line._port is not port
    line.close()
    line.close()


@pytest.mark.parametrize("booting", [BootingServer], indirect=True)
def test_a_connection_whose_peer_acknowledges_nothing_ends(booting):
    line = SerialLine(protocol, booting.path, protocol.BAUD, 0, None, FasterTimer(PACE))
    line.open()
    with socket.socket(fileno=os.dup(line._port.fileno())) as wire_socket:
        assert wire_socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == lines.UNACKNOWLEDGED_MS
    line.close()


@pytest.mark.parametrize("booting", [BootingServer], indirect=True)
def test_a_connection_that_the_server_ends_is_made_again_at_the_next_attempt(booting):
    line = SerialLine(protocol, booting.path, protocol.BAUD, 0, None, FasterTimer(PACE))
    line.open()
    booting.look()
    port = line._port
    booting.connection.shutdown(socket.SHUT_RDWR)
    wait_for(lambda: not line._in_order, 20, "the reader")
    line.open()
    assert line._port is not port
    wait_for(lambda: booting.opened == 2, 20, "the next connection")
    line.close()
