"""The iRat's wire by hand: topics, services, velocities that are forgotten, a hold that is answered at rest."""

import base64
import io
import time
from pathlib import Path

import pytest
from PIL import Image

from robots.kit.description import load
from robots.kit.drivers.irat.protocol import EVERY_S, TOPICS
from tests.conftest import wait_for
from tests.drivers.irat_wire import FASTER, WireClient, journal, operation, velocity

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

MOTION = load("irat")["motion"]


def at_rest(sim):
    wait_for(lambda: not sim.status()["moving"], 3, "rest")


def test_the_papers_topics_and_ours(irat, wire_client):
    camera = wire_client.newest("/irat/camera/image/compressed")
    picture = Image.open(io.BytesIO(base64.b64decode(camera["data"])))
    assert (picture.format, picture.size, camera["format"]) == ("JPEG", (416, 240), "jpeg")
    assert 3_000 < len(base64.b64decode(camera["data"])) < 12_000
    stamp = camera["header"]["stamp"]
    assert abs(stamp["secs"] + stamp["nsecs"] / 1e9 - time.time()) < 5
    battery = wire_client.newest("/irat/battery")
    assert battery["percentage"] == pytest.approx(0.9, abs=0.01)
    assert battery["power_supply_status"] == 2
    assert battery["current"] < 0 < battery["voltage"]
    assert len(wire_client.newest("/irat/ranges")["ranges"]) == 3
    assert wire_client.newest("/irat/velocities")["twist"]["linear"]["x"] == 0
    assert wire_client.newest("/irat/charger_current") == {"data": 0.0}
    assert wire_client.newest("/irat/state")["moving"] is False
    assert set(wire_client.newest("/irat/odom")["pose"]) == {"pose", "covariance"}


def test_pictures_come_at_20_hz_and_only_while_somebody_subscribes(irat, wire_client):
    before = irat.status()["pictures"]
    wire_client.beats(8)
    assert irat.status()["pictures"] == before, "none was taken in the time of eight"
    wire_client.say("subscribe", topic="/irat/camera/image/compressed", throttle_rate=0)
    frames = [wire_client.hear(lambda f: f["op"] == "publish") for _ in range(21)]
    stamps = [f["msg"]["header"]["stamp"] for f in frames]
    times = [s["secs"] + s["nsecs"] / 1e9 for s in stamps]
    assert FASTER * (times[-1] - times[0]) / 20 >= EVERY_S["/irat/camera/image/compressed"] * 0.95, (
        "no more often than that"
    )
    wire_client.say("unsubscribe", topic="/irat/camera/image/compressed")
    wire_client.beats(6)
    before = irat.status()["pictures"]
    wire_client.beats(8)
    assert irat.status()["pictures"] == before


def test_a_throttled_subscription_gets_no_more_than_it_asked_for(irat, wire_client):
    began = irat.clock.monotonic()
    wire_client.say("subscribe", topic="/irat/odom", throttle_rate=300)
    for _ in range(4):
        wire_client.hear(lambda f: f["op"] == "publish")
    assert irat.clock.monotonic() - began >= 0.85


def test_velocities_drive_the_wheels_and_are_told(irat, wire_client):
    before = irat.status()["pose"]
    assert wire_client.claim()["success"]
    wire_client.say("subscribe", topic="/irat/velocities")
    wire_client.say("subscribe", topic="/irat/odom")
    wire_client.drive_far(irat, 0.1, linear=0.1)
    wire_client.call("/irat/hold")
    for _ in range(2):  # of these the second one was made after the answer
        last = wire_client.hear(lambda f: f.get("topic") == "/irat/odom")
    way = before[1] - irat.status()["pose"][1]
    assert 0.08 < way < 0.2
    speeds = [f["msg"]["twist"]["linear"]["x"] for f in wire_client.heard if f.get("topic") == "/irat/velocities"]
    assert max(speeds) == pytest.approx(0.1, abs=0.02)
    place = last["msg"]["pose"]["pose"]["position"]["x"]
    assert place == pytest.approx(way, rel=0.15), "dead reckoning is near the truth after so short a way"


def test_a_velocity_is_forgotten_after_a_quarter_of_a_second(irat, wire_client):
    wire_client.claim()
    wire_client.drive(linear=0.15)
    wait_for(lambda: irat.count("rest"), 5, "rest")
    motion, rest = journal(irat, "motion")[-1], journal(irat, "rest")[-1]
    assert rest["end"] == "silence"
    assert FASTER * (rest["t"] - motion["t"]) <= MOTION["forget_s"] + 0.15 / MOTION["acceleration"] + 0.5
    assert rest["motion"] == motion["motion"]


def test_zero_velocity_ends_a_motion(irat, wire_client):
    wire_client.claim()
    wire_client.drive(angular=1.0)
    wire_client.drive()
    wait_for(lambda: irat.count("rest"), 5, "rest")
    assert journal(irat, "rest")[-1]["end"] == "done"
    assert irat.count("motion") == 1


def test_a_hold_is_answered_at_rest_and_refuses_velocities_meanwhile(irat, wire_client):
    wire_client.claim()

    def fast():
        wire_client.drive(linear=0.2)
        return abs(irat.status()["rims"][0]) > 0.1

    wait_for(fast, 5, "a fast robot")
    go = velocity(linear=0.2)
    wire_client.send_at_once(go, operation("call_service", id="hold", service="/irat/hold"), go)
    answer = wire_client.hear(lambda f: f.get("id") == "hold")
    answered = time.monotonic()
    assert answer["values"] == {"success": True, "message": "at rest"}
    assert irat.status()["reference"] == [0.0, 0.0]
    held, rest = journal(irat, "hold")[-1], journal(irat, "rest")[-1]
    assert held["t"] <= rest["t"] <= answered
    assert rest["end"] == "held"
    assert any("being held" in f.get("msg", "") for f in wire_client.heard if f["op"] == "status")
    begun = irat.count("motion")
    wire_client.beats(4)  # asked for after them, and longer than a velocity lasts
    assert irat.count("motion") == begun, "what was said before the answer starts nothing later"


def answering(wire_client, epoch, back=0, stamp=None, **twist):
    """Drive in answer to the newest odometry, one with that stamp, or one that is so many seconds older."""
    stamp = stamp or wire_client.newest("/irat/odom")["header"]["stamp"]
    message = {"epoch": epoch, "sec": stamp["secs"] - back, "nanosec": stamp["nsecs"], "twist": twist}
    wire_client.say("publish", topic="/irat/drive", msg=message)


def test_a_velocity_that_comes_late_moves_nothing(irat, wire_client):
    epoch = wire_client.claim()["epoch"]
    for back in (1, 3600, -2):
        answering(wire_client, epoch, back, angular={"z": 0.5})
        assert "odometry of another time" in wire_client.complaint()
    wire_client.say("publish", topic="/irat/drive", msg={"epoch": epoch, "twist": {"angular": {"z": 0.5}}})
    assert "odometry of another time" in wire_client.complaint(), "one without a stamp"
    assert (irat.count("motion"), irat.count("late")) == (0, 4)
    answering(wire_client, epoch, angular={"z": 0.5})
    wait_for(lambda: irat.count("motion") == 1, 5, "the motion")
    answering(wire_client, epoch, angular={"z": 9})
    assert "must be from -2.5 to 2.5" in wire_client.complaint()


def test_a_velocity_from_before_somebodys_hold_moves_nothing_after_its_answer(irat, wire_client):
    """It was on its way in another connection meanwhile."""
    epoch = wire_client.claim()["epoch"]
    stamp = wire_client.newest("/irat/odom")["header"]["stamp"]
    assert WireClient(irat).call("/irat/hold")["values"] == {"success": True, "message": "at rest"}
    answering(wire_client, epoch, stamp=stamp, angular={"z": 0.5})
    assert "before the hold" in wire_client.complaint()
    assert irat.count("motion") == 0
    answering(wire_client, epoch, angular={"z": 0.5})
    wait_for(lambda: irat.count("motion") == 1, 5, "the motion")


def test_a_velocity_moves_only_under_the_commanders_epoch_and_on_its_connection(irat, wire_client):
    epoch = wire_client.claim()["epoch"]
    stranger = WireClient(irat)
    answering(stranger, epoch, angular={"z": 0.5})
    assert "claim the robot first" in stranger.complaint(), "its epoch alone is not enough here"
    for wrong in (epoch - 1, epoch + 1):
        answering(wire_client, wrong, angular={"z": 0.5})
        assert f"epoch {wrong} does not command" in wire_client.complaint()
    wire_client.say("publish", topic="/irat/drive", msg={"twist": {"angular": {"z": 0.5}}})
    assert "epoch is 0" in wire_client.complaint()
    newer = stranger.claim()["epoch"]
    wire_client.hear(lambda frame: frame.get("level") == "warning")
    answering(wire_client, epoch, angular={"z": 0.5})
    assert "claim the robot first" in wire_client.complaint()
    assert irat.count("motion") == 0
    answering(stranger, newer, angular={"z": 0.5})
    wait_for(lambda: irat.count("motion") == 1, 5, "the motion")


def test_everybody_may_hold_and_nobody_else_drives(irat, wire_client):
    wire_client.claim()
    other = WireClient(irat)
    other.drive(linear=0.1)
    assert "claim the robot first" in other.complaint()
    assert irat.count("motion") == 0
    with wire_client.driving(linear=0.1):
        for _ in range(5):  # the commander drives on at once, which is another motion
            wait_for(lambda: irat.status()["moving"], 5, "the motion")
            assert other.call("/irat/hold")["values"]["success"]
    assert any(record["end"] == "held" for record in journal(irat, "rest"))


def test_a_hold_at_rest_is_answered_at_once(wire_client):
    assert wire_client.call("/irat/hold", seconds=1.0)["values"]["message"] == "at rest"


def test_the_end_of_the_commanders_connection_holds(irat, wire_client):
    wire_client.claim()
    wire_client.drive_for(0.4, linear=0.2)
    wire_client.line.socket.close()
    at_rest(irat)
    rest = journal(irat, "rest")[-1]
    assert rest["end"] in ("lost", "silence")
    wait_for(lambda: irat.count("disconnected") == 1, 3, "the end of the connection is noted")


def test_a_stranger_can_find_out_what_there_is(wire_client):
    assert set(wire_client.call("/rosapi/topics")["values"]["topics"]) == set(TOPICS)
    assert "/irat/hold" in wire_client.call("/rosapi/services")["values"]["services"]
    refused = wire_client.call("/irat/dance")
    assert refused["result"] is False
    assert "there is no service /irat/dance" in refused["values"]


def test_the_truth_is_not_on_the_wire(irat, wire_client):
    before = wire_client.newest("/irat/odom")["pose"]
    irat.fault("carried", 20)
    wait_for(lambda: irat.count("carried"), 3, "the hand that carries it")
    wire_client.beats(2)
    after = wire_client.newest("/irat/odom")["pose"]["pose"]["position"]
    assert after["x"] == pytest.approx(before["pose"]["position"]["x"], abs=1e-3)
    assert irat.status()["pose"][1] == pytest.approx(1.52, abs=0.03)


def test_the_simulator_runs_as_idle_as_it_is(irat):
    """A second of its time at rest and unwatched costs hardly any of the processor."""

    def used():
        stat = Path(f"/proc/{irat.process.pid}/stat").read_text()
        return sum(map(int, stat.rsplit(")", 1)[1].split()[11:13]))

    irat.clock.sleep(0.5)
    before = used()
    irat.clock.sleep(1.5)
    assert used() - before <= 9, "6 % of a core, twice what it may use on a machine that does nothing else"
