"""The address of a robot in the admin: a simulator must be installed and speak as this robot; nonsense is refused."""

import pytest

from robots.admin.forms import RobotForm
from robots.kit.installed import simulators

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def errors(driver, address):
    form = RobotForm({"name": "R", "slug": "r", "driver": driver, "address": address, "records": "off"})
    return form.errors.get("address", [])


def test_a_simulator_that_is_not_installed_is_refused_with_those_that_are():
    assert {"irat", "mercury", "pa10", "so101"} <= set(simulators())
    (told,) = errors("mercury", "sim:wrong")
    assert "There is no simulator 'wrong'" in told
    assert "sim:mercury" in told
    (told,) = errors("mercury", "sim:common")
    assert "no simulator 'common'" in told, "it is a part of the others"


@pytest.mark.parametrize(("driver", "other"), [("pa10", "mercury"), ("mercury", "irat"), ("irat", "pa10")])
def test_the_simulator_of_another_robot_is_refused(driver, other):
    (told,) = errors(driver, f"sim:{other}")
    assert f"Write sim:{driver}." in told
    assert errors(driver, f"sim:{driver}") == []


def test_a_package_s_own_simulator_is_known(installed):
    assert "turntable" in simulators()
    assert errors("turntable", "sim:turntable") == []


@pytest.mark.parametrize(
    "address",
    ["sim:", "sim:Mercury", "sim:../x", "sim:mercury:1", "serial:", "serial:ttyUSB0", "serial:/dev/", "tcp:", "tcp:host", "tcp:host:", "tcp:host:0",
     "tcp:host:99999", "tcp::9000", "tcp:ho st:1", "wrong", "usb:1", "mercury", "", ":"],
)  # fmt: skip
def test_nonsense_behind_any_scheme_is_refused_in_a_sentence(address):
    (told,) = errors("mercury", address)
    assert told.endswith(".")
