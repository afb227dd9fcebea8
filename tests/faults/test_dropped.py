"""Sockets that are ended or refused by rule are counted, and the log says how many."""

import contextlib
import json
import logging
import socket
from collections import Counter

import pytest
from django.conf import settings
from websockets.exceptions import InvalidStatus

from portal.edge import dropped as counting
from portal.edge.dropped import dropped
from portal.live import access
from tests.conftest import wait_for
from tests.faults.here import closed, handshake, heard, line

pytestmark = pytest.mark.timed

PONG = b"\x8a\x80\0\0\0\0"


@pytest.fixture
def log(web, caplog, monkeypatch):
    monkeypatch.setattr(counting, "TELL_S", 0.05)
    monkeypatch.setattr(counting, "_waits", set())  # a line that waits for longer
    monkeypatch.setattr(counting, "_told", Counter(dropped))  # drops of earlier tests are not told again
    caplog.set_level(logging.WARNING, "portal.edge.dropped")
    return caplog


def counted(log, reason, act):
    """Tell whether `act` counts one socket, and the log says so."""
    before = dropped[reason]
    act()
    wait_for(lambda: dropped[reason] == before + 1, 20, reason)
    wait_for(lambda: f"1 {reason}" in log.text, 20, "the line in the log")
    return True


def test_a_flood_of_messages(web, owned, log):
    def act():
        with line(web) as one:
            heard(one, "snapshot")
            with contextlib.suppress(Exception):
                for n in range(300):
                    one.send(json.dumps({"t": "ping", "n": n}))
            assert closed(one)[0] == 4429

    assert counted(log, "sent too many messages", act)


def test_a_flood_of_frames(web, owned, log):
    def act():
        with socket.create_connection(("127.0.0.1", web.port)) as one:
            one.sendall(handshake(web))
            one.recv(4096)
            with contextlib.suppress(OSError):
                one.sendall(PONG * 1000)
                while one.recv(65536):
                    pass

    assert counted(log, "sent too many frames", act)


def test_a_robot_that_is_full(web, owned, log, monkeypatch):
    monkeypatch.setitem(settings.LIMITS, "VIEWERS", 0)

    def act():
        with line(web) as one:
            assert closed(one)[0] == 4503

    assert counted(log, "found the robot's places taken", act)


def test_an_account_that_has_enough(web, owned, people, log, monkeypatch):
    monkeypatch.setattr(access.accounts(), "most", 0)

    def act():
        with line(web, people["ada"]) as one:
            assert closed(one)[0] == 4503

    assert counted(log, "of an account that has enough", act)


def test_an_address_that_has_enough(web, owned, log, monkeypatch):
    @contextlib.contextmanager
    def none(self, address):
        yield False

    monkeypatch.setattr("portal.edge.limits.AddressCount.one", none)

    def act():
        with pytest.raises(InvalidStatus):
            line(web)

    assert counted(log, "of an address that has enough", act)
