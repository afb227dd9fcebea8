import math
import time  # noqa: TID251 - epochs that only grow, and a pause
from contextlib import closing

import pytest

from robots.kit.clock import FasterTimer
from robots.kit.drivers.irat.driver import Driver as IratDriver
from robots.kit.drivers.mercury.driver import Driver
from robots.kit.drivers.pa10.driver import Driver as ArmDriver
from simulators.mercury.controller import RESET_S
from tests.conftest import wait_for
from tests.drivers import irat_wire
from tests.drivers.irat_wire import EPOCHS, WireClient
from tests.drivers.pa10_wire import CLOCK, FASTER, Terminal, allow, do
from tests.rig import ArmSimulator, IratSimulator, Simulator

HOME = (0.0, 0.42, 0.075)
PACE = 4  # times real time: the pace of the Mercury arm's simulator and driver
CORRIDOR = 50  # a place in the left arm of the U, heading away from the dock


@pytest.fixture(scope="session")
def mercury(tmp_path_factory):
    simulator = Simulator(tmp_path_factory.mktemp("mercury"), speed=PACE)
    yield simulator
    simulator.stop()


@pytest.fixture
def sim(mercury, request):
    """The simulator as if it had just been switched on: not calibrated, without a fault, nothing counted."""
    if mercury.process.poll() is not None:
        mercury.start()
    elif "ready" not in request.fixturenames and mercury.status()["pose"][:3] != pytest.approx(HOME, abs=1e-3):
        mercury.stop()
        (mercury.folder / "state.json").unlink()
        mercury.start()
    mercury.clear()
    mercury.power_cycle()
    time.sleep(RESET_S / mercury.speed)
    mercury.forget()
    return mercury


@pytest.fixture
def speed():
    """The arm's speed (m/s); a test that parametrizes it has motions of another length."""
    return 0.5


class FasterDriver(Driver):
    """The Mercury arm's driver, at the pace of the simulator."""

    clock = FasterTimer(PACE)


@pytest.fixture
def driver(sim, speed):
    made = FasterDriver(str(sim.folder / "tty"), {"speed": speed})
    yield made
    made.close()


@pytest.fixture
def ready(driver, speed):
    """A driver whose arm is calibrated and at home."""
    driver.connect()
    if driver.recover(allow).pose[:3] != pytest.approx(HOME, abs=1e-3):
        do(driver, "speed", speed=0.5)
        do(driver, "home")
        do(driver, "speed", speed=speed)
    return driver


@pytest.fixture(scope="session")
def shared(tmp_path_factory):
    watchdog = 600 * FASTER
    simulator = ArmSimulator(tmp_path_factory.mktemp("pa10"), watchdog=watchdog, nobody=watchdog, speed=FASTER)
    yield simulator
    simulator.stop()


@pytest.fixture
def arm(shared):
    """A driver whose arm rests above the table, in order."""
    shared.clear()
    made = ArmDriver(str(shared.folder / "tty"), {"epoch": time.monotonic_ns()})
    made.clock = CLOCK
    motion = made._description["motion"]  # on a busy machine the arm falls behind a clock that runs faster
    made._description = {**made._description, "motion": {**motion, "limit_s": motion["limit_s"] * FASTER}}
    with closing(made):
        made.connect()
        made.recover(allow)
        do(made, "gripper", closed=0)
        do(made, "ready")
        yield made


@pytest.fixture
def terminal(shared):
    shared.clear()
    wait_for(lambda: not shared.status()["moving"], 20, "rest")
    made = Terminal(shared)
    assert made.ask(f"i {time.monotonic_ns()}").startswith("ok epoch")
    if made.ask("w") == "e":
        made.ask("j 0 0 0 0 0 0")
        made.ask("W")
    made.ask("j 0 25 75 0 80 0")
    made.ask("W")
    yield made
    made.close()


@pytest.fixture(autouse=True)
def nobody_types_on():
    """Close what a test has left open, before the collector finds it in another."""
    yield
    while Terminal.OPEN:
        Terminal.OPEN.pop().close()


@pytest.fixture(scope="session")
def rat(tmp_path_factory):
    simulator = IratSimulator(tmp_path_factory.mktemp("irat"), speed=irat_wire.FASTER)
    yield simulator
    simulator.stop()


@pytest.fixture
def irat(rat):
    """The iRat's simulator at rest in mid-corridor, charged, without a fault, nothing counted; nobody commands."""
    if rat.process.poll() is not None:
        rat.start()
    rat.clear()
    rat.fault("charge", 0.9)
    wait_for(lambda: rat.status()["power"] and rat.status()["charge"] == pytest.approx(0.9, abs=0.01), 5, "the battery")
    rat.power_cycle()
    rat.fault("carried", CORRIDOR)
    wait_for(lambda: rat.status()["pose"][1] == pytest.approx(1.22, abs=0.03), 5, "the corridor")
    rat.forget()
    yield rat
    while WireClient.OPEN:
        WireClient.OPEN.pop().close()


@pytest.fixture
def wire_client(irat):
    """A stranger who speaks the iRat's wire by hand."""
    return WireClient(irat)


class Rat(IratDriver):
    """The iRat's driver in the time of its simulator; its parts take the clock when they are made."""

    clock = irat_wire.CLOCK


@pytest.fixture(scope="session")
def rat_owner(tmp_path_factory, rat):
    """One driver for all tests, because its brain is a process that takes long to start."""
    made = Rat(str(rat.folder / "tty"), {"epoch": next(EPOCHS), "folder": str(tmp_path_factory.mktemp("irat"))})
    made._roaming._clear_s = made._roaming._latest_s = math.inf  # its map would grow old in the middle of some test
    yield made
    made.close()


@pytest.fixture
def rat_driver(irat, rat_owner):
    """The iRat's driver, connected anew, with the map of the tests before."""
    rat_owner.on_packet = None
    rat_owner.senses.close()
    rat_owner.line.close()
    rat_owner.connect()
    wait_for(lambda: rat_owner.state().ready and rat_owner.senses.seeing, 120, "the brain")
    irat.forget()
    return rat_owner
