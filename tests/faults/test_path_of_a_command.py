"""How many files a command passes between the socket and the robot's wire, counted by what really runs."""

import contextlib
import json
import sys
import threading
from inspect import CO_COROUTINE

import pytest
from django.conf import settings as configured

from robots.models import Command
from tests.conftest import wait_for
from tests.faults.here import WebHere, line
from workers.wiring import Owner

pytestmark = pytest.mark.timed

MOST = 21  # one is the door before the driver (`workers/door.py`); without the robot's own folder: the driver of Mercury is the robot, and another robot has another
OWN = "robots/drivers/mercury/"
TIMED = ("portal/live/hub.py", "portal/live/sessions.py")  # they and what they call run by a timer of their own
BESIDE = {*TIMED, "portal/live/viewing.py", "portal/postgres/base.py"}  # and what sends, and waits for PostgreSQL
ROOT = str(configured.BASE_DIR)
START = 4  # bytes of code before a coroutine begins
OURS = tuple(f"{ROOT}/{room}/" for room in ("accounts", "portal", "queueing", "robots", "workers"))


def timed(frame):
    """Tell whether a function was called, near or far, by what runs by a timer."""
    while frame is not None:
        if frame.f_code.co_filename.removeprefix(f"{ROOT}/") in TIMED:
            return True
        frame = frame.f_back
    return False


class Path:
    """The files of ours whose functions were called, in the order of their first call."""

    def __init__(self):
        self.files, self._on, self._last, self._only = {}, False, "", None

    def follow(self, last="", only=None):
        """Record from now on, until `end` or until the function `last` was called; `only` is the number of a thread."""
        self._on, self._last, self._only = True, last, only

    def end(self):
        self._on = False

    @property
    def over(self):
        return not self._on

    def __call__(self, frame, event, arg):
        if self._only not in (None, threading.get_ident()):
            return
        if not self._on or event != "call" or not frame.f_code.co_filename.startswith(OURS):
            return
        if frame.f_code.co_flags & CO_COROUTINE and frame.f_lasti > START:  # it goes on; it was called before
            return
        at = frame.f_code.co_filename.removeprefix(f"{ROOT}/")
        if timed(frame):
            return
        self.files.setdefault(at, []).append(frame.f_code.co_qualname)
        if frame.f_code.co_qualname == self._last:
            self._on = False


@pytest.fixture
def path():
    made = Path()
    threading.setprofile(made)
    sys.setprofile(made)
    yield made
    sys.setprofile(None)
    threading.setprofile(None)


def quiet(socket):
    """Wait until nothing more comes."""
    with contextlib.suppress(TimeoutError):
        while True:
            socket.recv(timeout=1.5)


@contextlib.contextmanager
def first_byte(port, then):
    """Call `then` right before the first byte of a motion is written; what asks for the state goes on meanwhile."""
    real, here = port.write, threading.get_ident()

    def write(data):
        if threading.get_ident() == here:
            then()
        return real(data)

    port.write = write
    yield
    del port.write


def moved(owner, path, one, number, y):
    """Have one command sent and run, and record its path."""
    path.follow("Lane.wake")
    one.send(json.dumps({"t": "command", "kind": "move", "args": {"x": 0.0, "y": y}, "seq": number}))
    wait_for(lambda: path.over, 10, "the wake-up")
    wait_for(Command.objects.filter(client_seq=number).exists, 10, "its row")
    owner.link.seen()
    path.follow(only=threading.get_ident())
    with first_byte(owner.owned.driver.line._port, path.end):
        owner.motion.run_due()
    assert path.over


def test_a_command_passes_few_files(path, rig, people, settings):
    settings.FARHAND = {**settings.FARHAND, "LEASE_S": 120, "REDIS_GONE_S": 120}  # nothing renews them here
    type(rig.robot).objects.update(settings={"speed": 0.3})  # a robot with settings passes no more
    rig.own()
    web = WebHere()
    owner = Owner(rig.robot.slug)
    try:
        owner.own(lambda: False)
        owner.owned.running = True
        owner.connection.connect()
        owner.threads.begin("listen", owner.listener.loop)
        rig.grant()
        with line(web, people["ada"]) as one:
            quiet(one)  # what a new connection sets going has ended
            moved(owner, path, one, 1, 0.39)  # what is loaded once is not a part of the path
            quiet(one)
            path.files.clear()
            moved(owner, path, one, 2, 0.40)
    finally:
        owner.stop()
        web.stop()
    own = {name for name in path.files if name.startswith(OWN)}
    ours = set(path.files) - own - BESIDE
    print(*(f"{name}: {', '.join(dict.fromkeys(names))}" for name, names in path.files.items()), sep="\n")
    print(f"{len(ours)} files, and {len(own)} of the robot's own")
    last = {"workers/safety/gate.py", "workers/safety/memory.py", "workers/safety/lease.py"}  # asked before the byte
    assert {f"{OWN}driver.py", "portal/live/consumers.py", *last} <= set(path.files)
    assert {"Gate.check", "StopLatch.latched"} <= {name for names in path.files.values() for name in names}
    assert len(ours) <= MOST
