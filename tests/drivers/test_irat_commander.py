"""One commander of the iRat at a time, by an epoch that only grows."""

import pytest
from websockets.exceptions import ConnectionClosed

from tests.conftest import wait_for
from tests.drivers.irat_wire import EPOCHS, WireClient, journal


def test_a_stale_epoch_is_refused(irat, wire_client):
    old, new = next(EPOCHS), next(EPOCHS)
    assert wire_client.claim(new) == {"success": True, "message": "you command", "epoch": new}
    stale = WireClient(irat)
    answer = stale.claim(old)
    assert not answer["success"]
    assert answer["message"] == f"epoch {old} is over; {new} has commanded since"
    stale.drive(linear=0.1)
    assert "claim" in stale.complaint()
    assert irat.status()["epoch"] == new
    assert irat.count("motion") == 0


def test_a_stale_epoch_is_refused_after_the_newer_one_has_gone(irat, wire_client):
    old, new = next(EPOCHS), next(EPOCHS)
    wire_client.claim(new)
    wire_client.close()
    wait_for(lambda: irat.status()["epoch"] == 0, 5, "the end of the connection")
    assert not WireClient(irat).claim(old)["success"]


def test_a_newer_epoch_replaces_the_commander_and_brakes_first(irat, wire_client):
    wire_client.claim()
    newer, epoch = WireClient(irat), next(EPOCHS)
    with wire_client.driving(linear=0.15):
        wait_for(lambda: irat.status()["moving"], 5, "the motion")
        assert newer.claim(epoch)["success"]
        wait_for(lambda: not irat.status()["moving"], 3, "rest")
    assert journal(irat, "rest")[-1]["end"] == "replaced"
    begun = irat.count("motion")
    wire_client.drive(linear=0.15)  # the robot may have come to rest before the next velocity was due
    assert f"epoch {epoch} commands now" in wire_client.complaint()
    assert "claim the robot first" in wire_client.complaint()
    newer.drive(angular=0.5)
    wait_for(lambda: irat.count("motion") == begun + 1, 3, "the newer one's motion")
    assert journal(irat, "motion")[-1]["epoch"] == epoch


def test_the_same_epoch_again_waits_until_the_first_is_silent(irat, wire_client):
    epoch = next(EPOCHS)
    second = WireClient(irat)
    wire_client.claim(epoch)
    assert "another connection commands" in second.claim(epoch)["message"]
    irat.clock.sleep(1.2)
    assert second.claim(epoch)["success"], "an owner whose connection was lost comes back"


def test_a_loss_of_power_forgets_claims_and_ends_connections(irat, wire_client):
    wire_client.claim()
    before = irat.status()
    with wire_client.driving(linear=0.1):
        wait_for(lambda: irat.status()["moving"], 5, "the motion")
        irat.fault("power_cycle", count=1)
        wait_for(lambda: irat.status()["boot"] == before["boot"] + 1, 3, "the power")
    assert irat.status()["epoch"] == 0
    assert journal(irat, "rest")[-1]["end"] == "lost"
    with pytest.raises(ConnectionClosed):
        wire_client.status()
    again = WireClient(irat)
    assert again.status()["boot"] == before["boot"] + 1
    assert again.newest("/irat/odom")["pose"]["pose"]["position"]["x"] == pytest.approx(0.0, abs=0.01)
