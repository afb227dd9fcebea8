"""The iRat finds its dock by the markers, and counts as charging only by the charger's current."""

import pytest

from robots.kit.contract.errors import GrantOver, HardwareFault
from tests.conftest import wait_for
from tests.drivers.irat_wire import until
from tests.drivers.pa10_wire import allow

# a map that answers half a second late holds the robot, so nothing else runs beside it
pytestmark = pytest.mark.timed


def test_it_is_charging_only_with_a_current(rat_driver, irat):
    irat.fault("carried", -1)
    wait_for(lambda: rat_driver.state().values["charging"], 5, "current")
    assert rat_driver.state().mode == "charging"
    irat.fault("contacts_bent")
    wait_for(lambda: not rat_driver.state().values["charging"], 5, "no current")
    assert rat_driver.state().mode != "charging"


def test_a_docked_robot_charges_at_rest(rat_driver, irat):
    irat.fault("carried", -1)
    irat.fault("charge", 0.5)
    wait_for(lambda: rat_driver.state().values["charging"], 5, "current")
    irat.forget()
    told = []
    with pytest.raises(GrantOver):
        rat_driver.execute("charge", {}, until(1.5), told.append)
    assert irat.count("motion") == 0
    assert any("charging" in getattr(t, "text", "") for t in told)


def test_it_leaves_the_dock_backwards(rat_driver, irat):
    irat.fault("carried", -1)
    wait_for(lambda: rat_driver.state().values["charging"], 5, "current")
    late = until(30)

    def permit():
        if not rat_driver.state().values["charging"]:
            raise GrantOver("it has left")
        late()

    with pytest.raises(GrantOver, match="it has left"):
        rat_driver.execute("explore", {}, permit, lambda _: None)


def test_at_critical_charge_it_rests_and_calls_staff(rat_driver, irat):
    irat.fault("charge", 0.05)
    wait_for(lambda: rat_driver.senses.critical, 5, "the battery")
    irat.forget()
    for kind in ("charge", "explore"):
        with pytest.raises(HardwareFault, match="staff have to put the robot into its dock"):
            rat_driver.execute(kind, {}, allow, lambda _: None)
    assert irat.status()["moving"] is False
    assert "battery" in rat_driver.state().mode


def test_a_battery_that_was_charged_in_the_meantime_counts(rat_driver, irat):
    irat.fault("charge", 0.05)
    wait_for(lambda: rat_driver.senses.critical, 5, "the battery")
    rat_driver.senses.close()
    rat_driver.line.close()
    irat.fault("charge", 0.9)
    wait_for(lambda: irat.status()["charge"] > 0.8, 5, "a charged battery")
    assert rat_driver.connect().values["charge"] > 80


def test_it_finds_its_dock_and_charges(rat_driver, irat):
    irat.fault("carried", -1)
    wait_for(lambda: rat_driver.state().values["charging"], 5, "current")
    with pytest.raises(GrantOver):  # it learns from where the dock is seen
        rat_driver.execute("explore", {}, until(25), lambda _: None)
    irat.fault("charge", 0.96)
    wait_for(lambda: rat_driver.state().values["charge"] < 96.5, 5, "the battery")
    outcome = rat_driver.execute("charge", {}, until(400), lambda _: None)
    assert outcome.state.values["charging"] == 1.0
    assert irat.status()["charging"] is True
    assert all(irat.status()["contacts"])
