"""Why an operator's connection was lost, found out by the server's own connection, and listed."""

import socket
import struct

import pytest

from portal.edge.sockets import LOST
from queueing.models import LostCause, LostConnection, Turn
from robots.kit.clock import SYSTEM
from tests.conftest import wait_for
from tests.faults.here import heard, line
from tests.services.turns import drive

pytestmark = [pytest.mark.timed, pytest.mark.usefixtures("owned")]


@pytest.fixture
def driving(web, robot, people):
    return drive(robot, people["ada"], SYSTEM.now())


def reset(one, web):
    """Cut the line, without a word of WebSocket."""
    one.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    one.socket.close()


def connections(web):
    return [one for one in web.server.server_state.connections if hasattr(one, "cause")]


ENDS = {
    LostCause.PAGE: lambda one, web: one.close(),
    LostCause.CUT: reset,
    LostCause.NO_PONG: lambda one, web: web.ask(lambda: [each.keepalive_timeout() for each in connections(web)]),
    LostCause.NOT_READ: lambda one, web: web.ask(
        lambda: [(each._drop_unread(), each.transport.abort()) for each in connections(web)]
    ),
    LostCause.RESTART: lambda one, web: web.ask(lambda: [each.shutdown() for each in connections(web)]),
}


@pytest.mark.parametrize("cause", ENDS, ids=str)
def test_each_cause_is_found_out(web, driving, people, cause):
    one = line(web, people["ada"], legacy=True)
    assert heard(one, "snapshot")["me"]["grant"]
    wait_for(lambda: Turn.objects.get().connected, 10, "the presence of the operator")
    ENDS[cause](one, web)
    wait_for(LostConnection.objects.exists, 10, "the lost connection")
    lost = LostConnection.objects.get()
    assert (lost.turn, lost.cause) == (driving, cause)
    assert lost.side


def test_others_and_sockets_that_the_portal_closes_are_not_listed(web, driving, people):
    for person in (None, people["eve"]):
        with line(web, person) as other:
            heard(other, "snapshot")
    with line(web, people["ada"]) as one:
        heard(one, "snapshot")
        one.send("x" * 9000)
    web.nothing_left()
    assert not LostConnection.objects.exists()


def test_server_and_rows_know_the_same_causes():
    assert set(LOST) == set(LostCause.values) == set(ENDS)
