"""A byte stream over the real wire: from the turntable's socket through its owner and Redis to a page's WebSocket."""

import contextlib

import pytest
from websockets.sync.client import connect

from robots import services
from robots.kit.contract.streams import unpack
from tests.conftest import wait_for
from tests.rig import Web, worker

pytestmark = pytest.mark.timed

CELLS = 63


@pytest.fixture
def table(turntable, people):
    """The turntable with its simulator, its owner and a web process, in ada's turn."""
    robot, children = turntable()
    children.append(Web())
    return robot, people["ada"], children


class Page:
    """What a page knows of the stream."""

    def __init__(self, socket):
        self.socket = socket
        self.cells, self.heard = bytearray(CELLS), []

    def hear(self):
        """Take what has come, so that nothing waits in its way."""
        with contextlib.suppress(TimeoutError):
            while True:
                self._take(self.socket.recv(timeout=0.02))

    def _take(self, said):
        """A packet of the stream is drawn as the console draws it."""
        if isinstance(said, str) or said[0] != 3:
            return
        packet = unpack(said)
        if packet.key:
            self.cells[:] = packet.data
        else:
            assert packet.number == self.heard[-1].number + 1
            for at in range(0, len(packet.data), 2):
                self.cells[packet.data[at]] = packet.data[at + 1]
        self.heard.append(packet)

    def visited(self):
        self.hear()
        return {i for i, n in enumerate(self.cells) if n}


def watching(web):
    return connect(f"{web.url.replace('http', 'ws')}/ws/robots/turntable/", origin=web.url, max_size=None)


def completed(robot, ada, seq, kind, **args):
    command = services.issue(robot.slug, ada, kind, args, seq).command
    wait_for(lambda: type(command).objects.get(pk=command.pk).state == "completed", 20, kind)


def test_pages_are_told_everything_then_what_changes_and_newcomers_too(table):
    robot, ada, children = table
    with watching(children[2]) as socket:
        first = Page(socket)
        wait_for(first.visited, 10, "the key packet")
        assert first.heard[0].key
        completed(robot, ada, 1, "pace", pace=0.3)  # so that it is asked several times in each cell, which marks it
        completed(robot, ada, 2, "turn", angle=1.0)
        wait_for(lambda: len(first.visited()) >= 9, 10, "what the table passed")
        assert any(not packet.key for packet in first.heard), "it came as deltas"
        with watching(children[2]) as later:
            late = Page(later)
            wait_for(lambda: late.visited() >= first.visited(), 10, "the same")
            assert late.heard[0].key


def test_the_next_owner_begins_with_a_key_packet(table):
    _, _, children = table
    with watching(children[2]) as socket:
        page = Page(socket)
        wait_for(page.visited, 10, "the key packet")
        run = page.heard[-1].run
        children[1].kill()
        children[1] = worker("turntable")
        wait_for(lambda: page.visited() and page.heard[-1].run != run, 60, "the next owner's packet")
        assert next(packet for packet in page.heard if packet.run != run).key
