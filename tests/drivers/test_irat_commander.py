"""One commander of the iRat at a time, by an epoch that only grows."""

import pytest
from websockets.exceptions import ConnectionClosed

from simulators.irat.claims import SILENT_S
from tests.conftest import wait_for
from tests.drivers.irat_wire import EPOCHS, WireClient, journal

pytestmark = pytest.mark.timed


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


def ended(irat, how, drive):
    """Let a motion end so, and return what `drive` does; where the machine stalls, silence may have ended it before."""
    for _ in range(5):
        left = drive()
        ends = [record["end"] for record in journal(irat, "rest")]
        if ends[-1] == how:
            return left
    raise AssertionError(ends)


def test_a_newer_epoch_replaces_the_commander_and_brakes_first(irat):
    def replaced():
        older, newer = WireClient(irat), WireClient(irat)
        older.claim()
        epoch = next(EPOCHS)
        with older.driving(linear=0.15):
            wait_for(lambda: irat.status()["moving"], 5, "the motion")
            assert newer.claim(epoch)["success"]
            wait_for(lambda: not irat.status()["moving"], 3, "rest")
        return older, newer, epoch

    older, newer, epoch = ended(irat, "replaced", replaced)
    begun = irat.count("motion")
    older.drive(linear=0.15)  # the robot may have come to rest before the next velocity was due
    assert f"epoch {epoch} commands now" in older.complaint()
    assert "claim the robot first" in older.complaint()
    newer.drive(angular=0.5)
    wait_for(lambda: irat.count("motion") == begun + 1, 3, "the newer one's motion")
    assert journal(irat, "motion")[-1]["epoch"] == epoch


def test_the_same_epoch_again_waits_until_the_first_is_silent(irat):
    for _ in range(5):
        first, second, epoch = WireClient(irat), WireClient(irat), next(EPOCHS)
        began = irat.clock.monotonic()
        first.claim(epoch)
        answer = second.claim(epoch)
        if irat.clock.monotonic() - began < SILENT_S:
            break  # else the machine stalled, and the first one was silent for so long
    assert "another connection commands" in answer["message"]
    irat.clock.sleep(1.2)
    assert second.claim(epoch)["success"], "an owner whose connection was lost comes back"


def test_a_loss_of_power_forgets_claims_and_ends_connections(irat):
    def lost():
        client, boot = WireClient(irat), irat.status()["boot"]
        client.claim()
        with client.driving(linear=0.1):
            wait_for(lambda: irat.status()["moving"], 5, "the motion")
            irat.fault("power_cycle", count=1)
            wait_for(lambda: irat.status()["boot"] == boot + 1, 3, "the power")
        wait_for(lambda: irat.status()["epoch"] == 0, 3, "nobody commands")
        return client, boot

    client, boot = ended(irat, "lost", lost)
    with pytest.raises(ConnectionClosed):
        client.status()
    again = WireClient(irat)
    assert again.status()["boot"] == boot + 1
    assert again.newest("/irat/odom")["pose"]["pose"]["position"]["x"] == pytest.approx(0.0, abs=0.01)
