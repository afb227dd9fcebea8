"""A robot from a package of its own, found by its entry point: added, driven, stopped; the portal knows nothing of it."""

import shutil
import subprocess
import sys

import pytest
from django.conf import settings
from django.test import Client

from accounts.models import Clearance, Question
from portal.keep.seeding import add_robot
from portal.run.processes import robot_processes
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest
from robots.models import Command, Lease, Robot
from robots.states import Cycle, GrantKind
from tests.conftest import wait_for
from tests.rig import Child


def test_a_third_robot_is_a_package(transactional_db, redis_server, people, installed):
    bus.connection().flushall()
    robot = add_robot("turntable")
    shutil.rmtree(settings.VAR / "run", ignore_errors=True)  # a stop is remembered there
    assert Question.objects.filter(robot=robot).count() == 15
    children = []
    try:
        for spec in robot_processes(robot):
            children.append(Child(spec.name.replace(" ", "-"), list(spec.argv), **spec.env))
        wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 60, "the robot is in order")
        Clearance.objects.create(user=people["ada"], robot=robot, granted_at=SYSTEM.now())
        services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
        Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.OPERATING)

        def ended(command):
            command.refresh_from_db()
            return command.final

        with pytest.raises(BadRequest, match="angle must lie between -3 and 3"):
            services.issue(robot.slug, people["ada"], "turn", {"angle": 9}, 1)
        command = services.issue(robot.slug, people["ada"], "turn", {"angle": 1.0}, 1).command
        wait_for(lambda: ended(command), 20, "the turn")
        assert (command.state, command.result["verdict"]) == ("completed", "no camera")
        kept = Lease.objects.get(robot=robot).state
        assert kept["joints"] == pytest.approx([1.0], abs=1e-6)
        told = {"warmth": pytest.approx(21.0, abs=1e-6), "pace": 1.0}
        assert (kept["pose"], kept["values"]) == ([], told), "and nothing invented"
        far = services.issue(robot.slug, people["ada"], "turn", {"angle": -3.0}, 2).command
        wait_for(lambda: Command.objects.get(pk=far.pk).state == "acknowledged", 10, "it turns")
        SYSTEM.sleep(0.3)
        services.stop(robot, people["ada"])
        wait_for(lambda: ended(far), 10, "the stop")
        assert far.state == "cancelled"
        page = Client().get(f"/robots/{robot.slug}/").content.decode()
        assert 'src="/static/robots/turntable/console.js"' in page
        assert '"kind": "turn"' in page
    finally:
        for child in children[::-1]:
            child.kill()


@pytest.mark.timed
def test_a_driver_that_is_not_installed_is_named_in_words():
    done = subprocess.run(
        [sys.executable, "-c", "from robots.kit.contract.find import open_session; open_session('nowhere', '', {})"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "no driver named 'nowhere' is installed" in done.stderr
