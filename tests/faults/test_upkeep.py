"""From the click of staff to the next person's turn, with the real owner."""

import pytest

from queueing import services as queue
from queueing.models import Ticket, TicketState
from robots import services
from robots.grants import open_grant
from robots.kit.clock import SYSTEM
from robots.models import Command
from tests.conftest import at_length, wait_for


def upkeep(rig):
    grant = open_grant(rig.robot)
    return grant is not None and grant.kind == "upkeep"


@pytest.mark.parametrize("end", ["completed", at_length("stopped"), "killed"])
def test_from_the_click_of_staff_to_the_next_turn(rig, end):
    owner = rig.owner()
    ada, kim = rig.people["ada"], rig.people["kim"]
    ticket = queue.join(rig.robot, ada, SYSTEM.now())
    command = services.staff_command(rig.robot, kim, "calibrate")
    offered_under_it = []

    def offered():
        queue.tick(SYSTEM.now())
        busy = upkeep(rig)
        ticket.refresh_from_db()
        offered_under_it.append(busy and ticket.state == TicketState.OFFERED and upkeep(rig))
        return ticket.state == TicketState.OFFERED

    rig.moving()
    assert not offered()
    if end == "killed":
        owner.kill()
        rig.start_worker()
    elif end == "stopped":
        services.stop(rig.robot, kim)
        rig.final(command)
        SYSTEM.sleep(0.3)
        services.release_stop(rig.robot, kim, checked=True)
    wait_for(offered, 60, f"the offer ({rig.cycle()}: {rig.reason()})")
    assert not any(offered_under_it)
    command.refresh_from_db()
    assert command.state == {"completed": "completed", "stopped": "cancelled", "killed": "unknown"}[end]
    turn = queue.accept(rig.robot, ada, SYSTEM.now())
    assert Ticket.objects.get().state == TicketState.OPERATING
    assert rig.final(rig.issue("noop")).state == "completed"
    assert Command.objects.filter(grant=turn.grant).count() == 1
