"""Proof that those who could have acted have looked and have not, before a test says that nothing happened.

A time that has passed proves nothing on a busy machine, and on an idle one it is too long.
"""

import itertools
import time  # noqa: TID251 - the limit of a wait
from datetime import timedelta
from typing import Any

from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import Stopped
from robots.models import Command, Grant, Lease, Robot
from robots.states import ONE_COMMAND, CommandState, GrantEnd, GrantKind
from tests.conftest import wait_for
from workers.commands.rows import BROKEN_OFF

NUMBERS = itertools.count(10**9)  # no page counts so far
SOON_S = 20.0


def swept(robot: Robot, seconds: float = SOON_S) -> None:
    """Wait until the owner's lane `motion` has gone a whole round: it runs no command, and has looked at the rows.

    The proof is a command that looks as if its claim was never confirmed. This lane alone ends it, after it has run all
    that was due and has read the robot's row. The round that ends the first may have begun before; the one that ends
    the second has not.
    """
    spared = Grant.objects.filter(robot=robot).exclude(kind__in=ONE_COMMAND)  # those end with their command
    grant = spared.order_by("ended_at", "pk").first()  # an ended one, so that a page counts it to no turn of now
    ended = 0
    while ended < 2:
        now = SYSTEM.now()
        probe = Command.objects.create(
            robot=robot, grant=grant, client_seq=next(NUMBERS), kind="noop", epoch=Lease.objects.get(robot=robot).epoch,
            state=CommandState.ACCEPTED, created_at=now, deadline=now + timedelta(hours=1),
        )  # fmt: skip
        stirred(robot)

        def final(probe: Command = probe) -> bool:
            probe.refresh_from_db()
            return probe.final

        try:
            wait_for(final, seconds, "the owner's look at the rows")
        finally:
            Command.objects.filter(pk=probe.pk).delete()
        assert probe.state in (CommandState.CANCELLED, CommandState.UNKNOWN), probe.state
        ended += (probe.state, probe.reason) == (CommandState.CANCELLED, BROKEN_OFF)  # not at a change of the owner


def followed(robot: Robot, seconds: float = SOON_S) -> None:
    """Wait until the owner has read the rows of stop and grant, from beginning to end. Ends the open grant.

    The proof is a grant whose time is up, which here only the owner ends; after it has followed the stop.
    """
    for _ in range(2):  # the round that ends the first may have begun before
        grant = Grant.objects.filter(robot=robot, ended_at=None).first()
        if grant is None:
            grant = Grant.objects.create(robot=robot, kind=GrantKind.TURN, opened_at=SYSTEM.now(), epoch=0)
        Grant.objects.filter(pk=grant.pk).update(until=SYSTEM.now() - timedelta(seconds=1))
        stirred(robot)
        over = Grant.objects.filter(pk=grant.pk, end_code=GrantEnd.TIME_UP)
        wait_for(over.exists, seconds, "the owner's look at the grant")


def heard(rig: Any, who: str = "ada", seconds: float = SOON_S) -> None:
    """Wait until the owner has heard all that was published for it so far, and carries commands out.

    The proof is the release of controls, which comes over the same connection later than a stop: it ends a held motion
    before it begins. Somebody must have the turn.
    """
    until, said = time.monotonic() + seconds, []
    while time.monotonic() < until:
        kind, args = rig.wishes.jog(1)
        try:
            command = rig.issue(kind, who=who, **args)
            bus.send_keep_alive(rig.robot.slug, command.pk, False)
            command = rig.final(command)
        except Stopped as error:
            said.append(str(error))
            time.sleep(0.05)
            continue
        if command.result.get("ended") == "released":
            return
        said.append(f"{command.state}: {command.reason}")  # a stop that was pressed earlier; or it was heard later
    raise AssertionError(f"the owner has not heard what was published, not within {seconds} s: {said}")


def stirred(robot: Robot) -> None:
    """Have a robot that was idle looked after at once."""
    lease = Lease.objects.filter(robot=robot).first()
    bus.wake_owner(robot.slug, lease.epoch if lease else 0)
