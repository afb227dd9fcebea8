"""A real worker, a real simulator on a pty, a real Redis; the simulator's journal is the judge."""

import pytest

from robots import bus, services
from robots.grants import owner_alive
from robots.kit.clock import SYSTEM
from robots.models import Frame, Grant, Incident, Robot
from robots.states import Cycle, GrantKind
from tests.conftest import at_length, wait_for

CLICKS = ((-0.15, 0.35), (0.18, 0.5), (0.0, 0.42), (-0.18, 0.5), (0.18, 0.33))


def far(rig):
    return rig.issue("move", x=-0.2, y=0.30)


@pytest.mark.service
def test_a_turn_worth_of_commands(rig):
    rig.owner()
    rig.grant()
    for kind, args in (("move", {"x": 0.05, "y": 0.45}), ("down", {}), ("air", {}), ("up", {})):
        command = rig.final(rig.issue(kind, **args))
        assert command.state == "completed", command.reason
        assert None not in (command.accepted_at, command.sent_at, command.acknowledged_at, command.ended_at)
        frame = Frame.objects.get(command=command)
        assert frame.width == 192
        assert (frame.stable, frame.verdict) == (True, "stable"), frame.difference
    assert rig.sim.count("burst") == 1
    click = rig.final(rig.issue("click", still=Frame.objects.order_by("-id")[0].pk, u=130, v=50))
    assert click.state == "completed", click.reason
    assert click.kind == "move"


@pytest.mark.timed
@pytest.mark.length
def test_a_wake_up_that_was_never_sent_costs_a_tenth_of_a_second(rig, monkeypatch):
    rig.owner()
    rig.grant()
    monkeypatch.setattr(bus, "wake_owner", lambda *_: False)
    assert rig.final(rig.issue("down"), 5).state == "completed"


def rig_run(rig):
    from django.conf import settings

    return settings.VAR / "run"


@pytest.mark.timed
def test_redis_gone_when_a_click_is_made(rig):
    rig.owner()
    rig.grant()
    rig.redis.stop()
    before = rig.sim.count("motion")
    command = rig.issue("down")
    rig.final(command)
    # before the owner knows that the link is down, at its claim, or on the way, on a machine that is slow
    assert command.state in ("completed", "rejected", "cancelled")
    assert rig.sim.count("motion") == before + (command.state != "rejected")

    def refused():
        command = rig.final(rig.issue("up"))
        return command.reason if command.state == "rejected" else ""

    assert "live link is down" in wait_for(refused, 10, "the owner knows that the live link is down")
    rig.redis.start()
    wait_for(lambda: rig.final(rig.issue("up")).state == "completed", 15, "work goes on by itself")


@pytest.mark.timed
@pytest.mark.length
def test_sigterm_in_mid_motion_holds_first_and_leaves_nothing(rig):
    child = rig.owner()
    rig.grant()
    rig.slow()
    command = far(rig)
    rig.moving()
    assert child.stop(20) == 0
    assert not rig.sim.status()["moving"]
    assert rig.sim.count("hold") >= 1
    command.refresh_from_db()
    assert command.state == "cancelled"
    rig.owner_lease_free = not owner_alive(rig.lease(), SYSTEM.now())
    assert rig.owner_lease_free


@pytest.mark.timed
def test_a_hardware_fault_is_reset_and_kept_and_the_operator_is_told(rig):
    rig.owner()
    rig.grant()
    calibrations = rig.sim.count("calibrate")
    rig.sim.fault("power_cycle", count=1)
    wait_for(lambda: Incident.objects.exists(), 15, "an incident")
    wait_for(lambda: rig.sim.count("calibrate") > calibrations, 20, "the soft reset")
    wait_for(lambda: rig.reason() == "", 10, "the robot is well again")

    def works():
        return rig.final(rig.issue("down")).state == "completed"

    wait_for(works, 15, "the turn goes on")


@pytest.mark.timed
@pytest.mark.length
def test_no_soft_reset_while_a_stop_is_latched(rig):
    rig.owner()
    rig.grant()
    services.stop(Robot.objects.get(), rig.people["ada"])
    wait_for((rig_run(rig) / "mercury.stopped").exists, 3, "the latch")
    motions, calibrations = rig.sim.count("motion"), rig.sim.count("calibrate")
    rig.sim.fault("power_cycle", count=1)
    wait_for(lambda: Incident.objects.exists(), 15, "an incident")
    wait_for(lambda: rig.reason() == "The robot is stopped.", 20, "a soft reset is tried, and refused")
    rig.swept()
    assert (rig.sim.count("motion"), rig.sim.count("calibrate")) == (motions, calibrations)


@pytest.mark.timed
def test_handover_verifies_by_the_camera_and_fails_closed(rig):
    rig.owner()
    rig.sim.fault("cam_black")
    Robot.objects.update(cycle=Cycle.HANDOVER)
    wait_for(lambda: rig.cycle() == Cycle.FAULT, 20, "a fault")
    assert "camera is black" in rig.reason()
    rig.sim.clear()
    rig.wait_ready(40)
    assert Grant.objects.filter(ended_at=None).count() == 0
    assert Grant.objects.filter(kind=GrantKind.HANDOVER).count() >= 2


@pytest.mark.timed
@pytest.mark.parametrize("places", [CLICKS[:2], at_length(CLICKS)], ids=["two", "all"])
def test_calibration_measures_what_the_camera_really_does(rig, places):
    Robot.objects.update(calibration={})
    rig.start_worker()
    rig.wait_ready(90)
    found = Robot.objects.get().calibration
    for name, mm_per_px in (("down", 128 / 262), ("up", 203 / 262)):
        (a, _b, _), (_c, d, _) = found[name]["matrix"]
        assert abs(a * 1000 - mm_per_px) < 0.03
        assert abs(d * 1000 + mm_per_px) < 0.03
        assert found[name]["residual_mm"] < 1.0
    rig.grant()
    for x, y in places:
        for kind in ("up", "down"):
            assert rig.final(rig.issue("move", x=x, y=y)).state == "completed"
            assert rig.final(rig.issue(kind)).state in ("completed", "rejected")
            still = Frame.objects.order_by("-id")[0]
            target = rig.final(rig.issue("click", still=still.pk, u=140, v=60))
            assert target.state == "completed", target.reason
            z = still.pose[2]
            k = (128 + z * 1000) / 262
            u, v = 140 - 95.5, 60 - 82.0
            turn = 0.0419  # the mounting's true angle, rad
            dx, dy = k * u, -k * v
            wanted = (x * 1000 + 3.0 + dx * 1 - dy * turn, y * 1000 - 2.2 + dy * 1 + dx * turn)
            pose = rig.sim.status()["pose"]
            assert abs(pose[0] * 1000 - wanted[0]) < 1.8
            assert abs(pose[1] * 1000 - wanted[1]) < 1.8


@pytest.mark.timed
@pytest.mark.length
def test_a_full_disk_loses_the_kept_picture_only(rig, settings):
    settings_dir = settings.MEDIA_ROOT
    rig.start_worker(FARHAND_MEDIA="/proc/nowhere")
    wait_for(lambda: rig.cycle() == Cycle.FAULT, 40, "a robot whose picture cannot be kept is not offered")
    assert "disk" in rig.reason()
    rig.grant()
    command = rig.final(rig.issue("down"))
    assert command.state == "completed"
    assert "disk may be full" in command.result["note"]
    services.stop(Robot.objects.get(), rig.people["ada"])
    wait_for(lambda: rig.sim.count("hold") >= 1, 3, "the stop works all the same")
    assert settings_dir
