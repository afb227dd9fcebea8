import pytest

from robots.drivers.mercury.driver import Driver
from tests.rig import Simulator


@pytest.fixture
def sim(tmp_path):
    simulator = Simulator(tmp_path)
    yield simulator
    simulator.stop()


@pytest.fixture
def speed():
    """Of the arm, m/s; a test that parametrizes it has motions of another length."""
    return 0.5


@pytest.fixture
def driver(sim, speed):
    made = Driver(str(sim.folder / "tty"), {"speed": speed})
    yield made
    made.close()


@pytest.fixture
def ready(driver):
    """A driver whose arm is calibrated and at home."""
    driver.connect()
    driver.recover(lambda: None)
    return driver
