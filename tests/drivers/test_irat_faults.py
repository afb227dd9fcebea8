"""The iRat's faults: what the paper had, and what wheels, sensors and people do besides."""

import base64
import math
import signal

import pytest

from tests.conftest import wait_for
from tests.drivers.irat_wire import WireClient, journal

pytestmark = pytest.mark.timed

CAMERA = "/irat/camera/image/compressed"


def jpeg(wire_client):
    return base64.b64decode(wire_client.newest(CAMERA)["data"])


def grey(data):
    import cv2
    import numpy as np

    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)


def charger(wire_client):
    return wire_client.newest("/irat/charger_current")["data"]


def dock(irat):
    """Have somebody carry the robot into its dock and push it in, nearly empty."""
    irat.fault("charge", 0.5)
    irat.fault("carried", -1)
    wait_for(lambda: irat.status()["contacts"] == [True, True], 3, "the dock")


def test_a_silent_radio_stops_the_wheels_and_comes_back(irat, wire_client):
    wire_client.claim()
    wire_client.drive_for(0.4, linear=0.1)
    irat.fault("awol")
    wire_client.drive_for(0.5, linear=0.1)
    wait_for(lambda: not irat.status()["moving"], 3, "rest, although velocities are still sent")
    assert journal(irat, "rest")[-1]["end"] == "silence"
    with pytest.raises(TimeoutError):
        wire_client.call("/irat/status", seconds=0.5)
    with pytest.raises(TimeoutError):
        WireClient(irat, open_timeout=0.5)
    irat.clear()
    assert wire_client.status()["moving"] is False


def test_answers_that_do_not_arrive(irat, wire_client):
    wire_client.claim()
    irat.fault("mute")
    wire_client.drive(angular=0.5)
    wait_for(lambda: irat.count("motion"), 3, "the motion: it hears")
    with pytest.raises(TimeoutError):
        wire_client.call("/irat/status", seconds=0.5)


def test_late_answers(irat, wire_client):
    irat.fault("slow", 0.3)
    began = irat.clock.monotonic()
    wire_client.status()
    assert irat.clock.monotonic() - began >= 0.3


def test_blocked_wheels_are_told_as_a_stall(irat, wire_client):
    wire_client.claim()
    irat.fault("stall")
    with wire_client.driving(linear=0.1):
        wait_for(lambda: wire_client.status()["stalled"], 5, "a stall")
        irat.clear()
        wait_for(lambda: not wire_client.status()["stalled"], 5, "wheels that turn")
    assert irat.count("stalled") >= 1


def test_slipping_wheels_turn_without_the_robot(irat, wire_client):
    wire_client.claim()
    irat.fault("slip", 1.0)
    before = irat.status()["pose"][:2]
    wire_client.drive_for(1.2, linear=0.2)
    wire_client.call("/irat/hold")
    believed = wire_client.newest("/irat/odom")["pose"]["pose"]["position"]
    assert math.hypot(believed["x"], believed["y"]) > 1.5 * math.dist(before, irat.status()["pose"][:2])


def test_a_dead_range_sensor_reads_nothing_near(irat, wire_client):
    right, _, left = wire_client.newest("/irat/ranges")["ranges"]
    assert right < 0.35
    assert left < 0.35
    irat.fault("ir_dead", 0b100)
    wait_for(
        lambda: wire_client.newest("/irat/ranges")["ranges"][0] == pytest.approx(0.40), 5, "a dead sensor on the right"
    )
    assert wire_client.newest("/irat/ranges")["ranges"][2] < 0.35


def test_charging_needs_both_contacts(irat, wire_client):
    assert charger(wire_client) == 0
    dock(irat)
    wait_for(lambda: charger(wire_client) > 1.0, 3, "the charger's current")
    assert wire_client.newest("/irat/battery", 3)["power_supply_status"] == 1
    assert wire_client.status()["charging"] is True
    irat.fault("contacts_bent")
    wait_for(lambda: charger(wire_client) == 0, 3, "no current")
    assert wire_client.newest("/irat/battery", 3)["power_supply_status"] == 2
    assert irat.status()["contacts"] == [True, True], "it stands where it stood"
    assert [r["event"] for r in irat.journal() if "charging" in r["event"]] == ["charging", "not_charging"]


def test_an_empty_battery_ends_everything_until_the_robot_is_carried_to_its_dock(irat, wire_client):
    wire_client.claim()
    irat.fault("charge", 0.0201)
    wire_client.drive_for(0.3, linear=0.1)
    irat.fault("charge", 0.01)
    wait_for(lambda: irat.count("flat"), 3, "a flat battery")
    wait_for(lambda: not irat.status()["moving"], 1, "rest")
    with pytest.raises(TimeoutError):
        WireClient(irat, open_timeout=0.5)
    irat.fault("carried", -1)
    wait_for(lambda: irat.count("power_back"), 3, "power")
    assert WireClient(irat).status()["charging"] is True


def test_frozen_black_and_missing_pictures(irat, wire_client):
    assert jpeg(wire_client) != jpeg(wire_client), "the sensor's noise: no two pictures are the same"
    irat.fault("cam_freeze")
    wait_for(lambda: jpeg(wire_client) == jpeg(wire_client), 10, "a frozen picture")
    frozen = jpeg(wire_client)
    irat.fault("carried", 10)
    wait_for(lambda: irat.count("carried"), 5, "the new place")
    assert jpeg(wire_client) == frozen
    irat.clear()
    wait_for(lambda: jpeg(wire_client) != frozen, 10, "another picture")
    assert grey(jpeg(wire_client)).mean() > 40
    irat.fault("cam_black")
    wait_for(lambda: grey(jpeg(wire_client)).mean() < 2, 10, "a black picture")
    irat.fault("cam_gone")
    wait_for(lambda: no_picture(irat), 20, "no picture")


def no_picture(irat):
    """Return whether a new subscriber gets none within half a second."""
    one = WireClient(irat)
    try:
        one.newest(CAMERA, 0.5)
    except TimeoutError:
        return True
    finally:
        one.close()
    return False


def test_a_false_marker_hangs_where_no_dock_is(irat, wire_client):
    import numpy as np

    irat.fault("carried", 10)
    irat.clock.sleep(0.2)
    before = grey(jpeg(wire_client)).astype(int)
    seen = 0
    for number in range(1, 40):
        irat.fault("false_marker", number)
        irat.clock.sleep(0.1)
        seen = max(seen, int((np.abs(grey(jpeg(wire_client)).astype(int) - before) > 60).sum()))
        if seen > 50:
            break
    assert seen > 50, "one of the walls that can be seen from here"


def test_it_starts_again_where_it_was_killed(irat, wire_client):
    wire_client.claim()
    wire_client.drive_far(irat, 0.15, linear=0.1)  # far enough that its place was kept on the way
    there = irat.status()
    irat.process.send_signal(signal.SIGKILL)
    irat.process.wait()
    irat.start()
    here = irat.status()
    assert math.dist(here["pose"][:2], there["pose"][:2]) < 0.1 * 1.0, "at most half a second ago"
    assert here["pose"][1] < 1.24 - 0.03
    assert here["charge"] == pytest.approx(there["charge"], abs=0.01)
    assert here["boot"] == there["boot"] + 1
    assert here["moving"] is False
    assert WireClient(irat).newest("/irat/odom")["pose"]["pose"]["position"]["x"] == pytest.approx(0.0, abs=1e-3)


def test_the_view_from_above_has_an_address_of_its_own(irat):
    import urllib.request

    import numpy as np

    address = (irat.folder / "overhead").read_text().strip()
    assert address.split(":")[-1] != irat.address.split(":")[-1]
    with urllib.request.urlopen(f"{address}/snapshot.jpg", timeout=20) as answer:
        picture = grey(answer.read())
    assert picture.shape == (580, 640)
    irat.fault("carried", 10)
    wait_for(lambda: irat.count("carried"), 5, "the new place")
    with urllib.request.urlopen(f"{address}/snapshot.jpg", timeout=20) as answer:
        moved = np.abs(grey(answer.read()).astype(int) - picture) > 40
    assert 200 < moved.sum() < 8000, "only the robot is elsewhere"
