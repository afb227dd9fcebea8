"""The iRat in the whole house: it explores, takes a guest's goal, charges in the middle of it, and finishes it.

It also does so while no page is served.
"""

import shutil
import signal

import pytest
from django.conf import settings
from django.test import Client

from portal.keep.seeding import add_robot
from portal.run.processes import robot_processes
from queueing import services as queue
from queueing.models import Job, QueueRobot
from queueing.services import Asker, ask
from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Command, Incident, Lease, Robot
from robots.states import Cycle, GrantEnd
from tests.conftest import wait_for
from tests.rig import Board, Child, Web, housekeeping

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed
EXPERIENCES = 150  # a map that has left the first corridor
HALTED_S = 100.0  # longer than the robot goes on for nobody, and than its last look for watchers counts


@pytest.fixture
def rat_house(transactional_db, redis_server):
    bus.connection().flushall()
    shutil.rmtree(settings.VAR / "run", ignore_errors=True)
    robot = add_robot("irat")
    QueueRobot.objects.filter(robot=robot).update(rest_after_min=None)
    for folder in (robot.rig_dir, settings.VAR / "robots" / robot.slug):
        shutil.rmtree(folder, ignore_errors=True)
    children = [Child(spec.name.replace(" ", "-"), list(spec.argv), **spec.env) for spec in robot_processes(robot)]
    robot.children = children
    yield robot
    for child in children[::-1]:
        child.stop()


@pytest.fixture
def web(rat_house):
    """The web process; the queue is advanced by the housekeeping worker."""
    children = [Web(), housekeeping()]
    yield children[0]
    for child in children:
        child.kill()


def told(robot):
    """Return the newest values of the robot; the queue goes on meanwhile."""
    queue.tick(SYSTEM.now())
    return (Lease.objects.get(robot=robot).state or {}).get("values", {})


def goal(robot, guest, **args):
    return ask(Robot.objects.get(pk=robot.pk), Asker(guest=guest * 64, network="192.0.2.1"), "goal", args, SYSTEM.now())


def with_a_goal(robot):
    """Ask for a goal once there is a map; return the simulator's board, the map's number and the job."""
    wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 150, "the robot is in order")
    wait_for(lambda: told(robot).get("experiences", 0) > EXPERIENCES, 200, "a map")
    number = told(robot)["map"]
    return Board(robot.rig_dir), number, goal(robot, "a", map=number, x=0.0, y=-0.5, experience=50)


def test_a_low_battery_in_mid_goal_is_charged_and_the_goal_is_finished(rat_house):
    robot = rat_house
    board, number, job = with_a_goal(robot)
    refused = goal(robot, "b", map=number + 7, x=0.0, y=0.0)
    running = Command.objects.filter(kind="goal", state="acknowledged")
    wait_for(lambda: told(robot) and running.exists(), 30, "the goal is on its way")
    board.fault("charge", 0.19)
    wait_for(lambda: told(robot) and Command.objects.filter(kind="charge").exists(), 30, "the need")
    wait_for(lambda: told(robot) and Job.objects.get(pk=job.pk).state == "waiting", 10, "it keeps its place")
    wait_for(lambda: told(robot).get("charging"), 400, "the dock")
    assert board.status()["charging"] is True
    board.fault("charge", 0.968)
    wait_for(
        lambda: told(robot) and not Job.objects.filter(state__in=("waiting", "running")).exists(), 400, "the goals"
    )
    job.refresh_from_db()
    refused.refresh_from_db()
    assert (job.state, job.reason, job.charged, job.runs.count()) == ("done", "", 1.0, 2)
    assert job.runs.first().grant.end_code == GrantEnd.PREEMPTED
    assert (refused.state, refused.charged) == ("failed", 0.0)
    assert "cleared" in refused.reason
    charge = Command.objects.filter(kind="charge").order_by("id").last()
    assert charge.state == "completed"
    rows = {row["label"]: row["value"] for row in Client().get("/robots/irat/statistics.json").json()["rows"]}
    ends = [rows[name] for name in ("Goals reached", "Dropped, because the map was cleared")]
    assert ends == [1, 1]
    assert rows["Recharges"] == Command.objects.filter(kind="charge", state="completed").count() >= 1
    assert rows["Driven, by odometry"] > 1.0


def test_a_crash_in_mid_goal_ends_it_unknown_and_who_waits_keeps_the_place(rat_house):
    robot = rat_house
    board, number, job = with_a_goal(robot)
    running = Command.objects.filter(kind="goal", state="acknowledged")
    wait_for(lambda: told(robot) and running.exists() and board.status()["moving"], 30, "the goal is on its way")
    other = goal(robot, "b", map=number, x=0.0, y=-0.5, experience=40)
    tag = other.start_tag
    owner = next(child for child in robot.children if child.pid == Lease.objects.get(robot=robot).pid)
    owner.kill()
    wait_for(lambda: not board.status()["moving"], 10, "rest without an owner")
    motions = board.count("motion")
    spec = robot_processes(robot)[-1]
    robot.children.append(Child("owner-again", list(spec.argv), **spec.env))
    wait_for(lambda: told(robot) and Job.objects.get(pk=job.pk).ended_at, 90, "the end of the goal")
    job.refresh_from_db()
    assert (job.state, job.charged, job.runs.count()) == ("unknown", 0.0, 1)
    assert job.args["experience"] == 50, "a click on the same place makes a new goal"
    other.refresh_from_db()
    assert other.state == "running" or (other.state, other.start_tag) == ("waiting", tag)
    wait_for(lambda: told(robot) and Job.objects.get(pk=other.pk).ended_at, 400, "who waited is served")
    other.refresh_from_db()  # how far it comes is the robot's own affair, and on a busy machine its map answers late
    assert other.state == "done" or "was not reached within" in other.reason, (other.state, other.reason)
    assert board.count("motion") > motions
    assert Command.objects.filter(kind="goal").count() == 2, "none runs twice"
    assert told(robot)["map"] == number, "the map was kept"


def test_at_critical_charge_staff_are_called_and_it_is_in_order_again_once_it_charges(rat_house):
    robot = rat_house
    wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 150, "the robot is in order")
    wait_for(lambda: told(robot) and Command.objects.filter(kind="explore").exists(), 60, "it roams")
    board = Board(robot.rig_dir)
    board.fault("charge", 0.05)
    wait_for(lambda: told(robot) and Robot.objects.get(pk=robot.pk).reason, 60, "a word for staff")
    assert "staff have to put the robot into its dock" in Robot.objects.get(pk=robot.pk).reason
    assert Incident.objects.filter(text__contains="almost flat", closed_at=None).exists()
    wait_for(lambda: not board.status()["moving"], 10, "rest")
    motions = board.count("motion")
    job = goal(robot, "c", map=told(robot)["map"], x=0.0, y=0.0)
    for _ in range(20):
        told(robot)
        SYSTEM.sleep(0.2)
    assert board.count("motion") == motions, "nothing moves it before it has power"
    job.refresh_from_db()
    assert job.state == "waiting"
    board.fault("carried", -1)
    board.fault("charge", 0.5)
    wait_for(lambda: told(robot).get("charging"), 60, "the dock")
    wait_for(lambda: told(robot) and not Robot.objects.get(pk=robot.pk).reason, 60, "in order again by itself")
    # one of the motion, one of the connection that was tried again and again
    assert Incident.objects.filter(text__contains="almost flat").count() <= 2, "not one for each attempt"


def test_while_the_web_process_is_halted_the_robot_does_its_goal_and_roams_on(rat_house, web):
    robot = rat_house

    def values():
        return (Lease.objects.get(robot=robot).state or {}).get("values", {})

    wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 150, "the robot is in order")
    wait_for(lambda: values().get("experiences", 0) > EXPERIENCES, 200, "a map")
    job = goal(robot, "d", map=values()["map"], x=0.0, y=-0.5, experience=50)
    web.signal(signal.SIGSTOP)
    halted = SYSTEM.monotonic()
    QueueRobot.objects.filter(robot=robot).update(rest_after_min=1, watched_at=SYSTEM.now())
    assert not web._answers()
    wait_for(lambda: Job.objects.get(pk=job.pk).ended_at, 200, "the goal")
    job.refresh_from_db()
    assert (job.state, job.reason, job.charged) == ("done", "", 1.0)
    while SYSTEM.monotonic() < halted + HALTED_S:
        SYSTEM.sleep(1.0)
    since, driven = SYSTEM.now(), values()["driven"]
    wait_for(lambda: values()["driven"] > driven + 0.3, 60, "it goes on, although nobody can watch")
    wait_for(lambda: Command.objects.filter(kind="explore", created_at__gt=since).exists(), 90, "the next slice")
    assert not web._answers()
    web.signal(signal.SIGCONT)
    wait_for(web._answers, 30, "the web process goes on where it was halted")
