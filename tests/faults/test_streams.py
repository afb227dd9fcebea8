"""A byte stream over the real wire: from the turntable's socket through its owner and Redis to a page's WebSocket."""

import contextlib
import shutil

import pytest
from django.conf import settings
from websockets.sync.client import connect

from accounts.models import Clearance
from portal.keep.seeding import add_robot
from portal.run.processes import robot_processes
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.contract.streams import unpack
from robots.models import Robot
from robots.states import Cycle, GrantKind
from tests.conftest import wait_for
from tests.rig import Child, Web, worker

pytestmark = pytest.mark.timed

CELLS = 63


@pytest.fixture
def table(transactional_db, redis_server, people, installed):
    """The turntable with its simulator, its owner and a web process, in ada's turn."""
    bus.connection().flushall()
    robot = add_robot("turntable")
    shutil.rmtree(settings.VAR / "run", ignore_errors=True)
    simulator = next(p for p in robot_processes(robot) if p.name.endswith("robot"))
    children = [Child("turntable-robot", list(simulator.argv), **simulator.env), worker("turntable"), Web()]
    try:
        wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 60, "the robot is in order")
        Clearance.objects.create(user=people["ada"], robot=robot, granted_at=SYSTEM.now())
        services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
        Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.OPERATING)
        yield robot, people["ada"], children
    finally:
        for child in children[::-1]:
            child.kill()


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
