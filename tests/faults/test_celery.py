"""Celery begins and ends a robot's owner, delivers wake-ups, and keeps the schedule."""

from celery import current_app

from queueing import services as queue
from queueing.models import TicketState
from robots import bus
from tests.conftest import wait_for
from tests.rig import housekeeping


def test_a_worker_begins_its_owner_and_gives_the_robot_back_at_its_end(rig):
    worker = rig.start_worker()
    rig.wait_ready()
    assert rig.lease().pid == worker.pid
    worker.stop()
    assert rig.lease().pid == 0


def test_a_wake_up_is_taken_from_the_queue_of_the_owners_epoch_and_from_no_other(rig):
    rig.owner()
    epoch = rig.lease().epoch
    mine, other = (bus.queue_name(rig.robot.slug, number) for number in (epoch, epoch + 1))
    for name in (other, mine):
        current_app.send_task(bus.WAKE_TASK, queue=name, ignore_result=True, retry=False)
    wait_for(lambda: bus.connection().llen(mine) == 0, 20, "the wake-up is taken")
    assert bus.connection().llen(other) == 1


def test_housekeeping_offers_the_robot_by_its_schedule(rig):
    rig.owner()
    ada = rig.people["ada"]
    ticket = queue.join(rig.robot, ada, rig.now())
    child = housekeeping()

    def offered():
        queue.note_presence(rig.robot, ada, rig.now(), False, "a session")
        ticket.refresh_from_db()
        return ticket.state == TicketState.OFFERED

    try:
        wait_for(offered, 60, "an offer")
    finally:
        child.kill()
