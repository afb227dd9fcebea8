"""Bury again, from the admin's verb to the sand: the real owner, driver and simulated Mercury in virtual time."""

import json

import numpy as np
import pytest
from django.contrib.auth.models import Permission

from operatorlog import finds
from operatorlog.errors import LogError
from operatorlog.finds import Report
from operatorlog.models import Find, Piece, Round
from queueing.models import Turn
from robots.grants import end_grant, open_grant
from robots.models import Robot
from robots.states import Cycle, GrantEnd
from simulators.mercury.sand import COVER_MM
from tests.unit.sand_beds import fresh
from tests.world.mercury import MercuryRig
from tests.world.seeds import hunt

pytestmark = pytest.mark.parametrize("which", ["mercury"], indirect=True)


@pytest.fixture
def moderator(people):
    root = people["kim"]
    root.user_permissions.add(*Permission.objects.filter(codename__in=("renew_round", "change_find", "change_robot")))
    return type(root).objects.get(pk=root.pk)


def bare(bed):
    return bool(((bed.sand - bed.rigid < COVER_MM) & (bed.rigid > 0)).any())


def hidden(one):
    return {piece.name: (piece.x, piece.y) for piece in one.pieces.all()}


def in_sand(portal):
    stored = json.loads((portal.rig.folder / "pieces.json").read_text())
    return stored["number"], {name: (x / 1000, y / 1000) for name, (x, y) in stored["places"].items()}


def a_find(portal, first):
    """Dig for the watch as an operator does until it lies bare; return the ended turn."""
    portal.grant()
    grant = open_grant(portal.robot)
    turn = Turn.objects.create(robot=portal.robot, user=portal.people["ada"], grant=grant, started_at=portal.world.now(),
                               until=grant.until, base_until=grant.until, last_seen=portal.world.now())  # fmt: skip
    x, y = hidden(first)["watch"]
    assert portal.final(portal.issue("move", x=x, y=y)).state == "completed"
    assert portal.final(portal.issue("down")).state == "completed"
    for _ in range(5):
        assert portal.final(portal.issue("air", seconds=0.4)).state == "completed"
    portal.until(lambda: bare(portal.rig.sim.bed), 20, "the watch")
    now = portal.world.now()
    end_grant(grant, GrantEnd.FINISHED, "", now)
    Turn.objects.filter(pk=turn.pk).update(ended_at=now)
    turn.refresh_from_db()
    return turn, Report("a watch", x=round(x, 4), y=round(y, 4))


def bury_again(portal, moderator):
    Round.objects.all().delete()
    Turn.objects.all().delete()
    portal.ready()
    first = finds.begin_first(portal.robot, portal.world.now())
    assert in_sand(portal) == (1, hidden(first)), "the register and the sand agree"
    turn, report = a_find(portal, first)
    Robot.objects.filter(pk=portal.robot.pk, cycle=Cycle.OPERATING).update(cycle=Cycle.HANDOVER)
    portal.ready()
    portal.until(lambda: open_grant(portal.robot) is None, 60, "nobody uses it")
    before = portal.rig.sim.bed
    assert finds.bury_again(first, moderator, finds.NextRound("Whose story?"), portal.world.now())
    present = Round.objects.get(ended_at=None)
    assert portal.final(present.command).state == "completed", present.command.reason
    portal.until(lambda: portal.rig.sim.bed is not before, 20, "the bed")
    bed = portal.rig.sim.bed
    assert not bare(bed)
    assert np.array_equal(bed.sand, fresh(portal.world.seed + 1, portal.rig.sim._places).sand), "it is flat again"
    assert in_sand(portal) == (2, hidden(present))
    assert not {*hidden(first).values()} & {*hidden(present).values()}
    # an old find does not match
    find = finds.report(turn, portal.people["ada"], report, portal.world.now())
    assert find.round == first
    new = Piece.objects.get(round=present, name="watch")
    with pytest.raises(LogError, match="Choose a piece of round 1"):
        finds.decide(find, moderator, Find.State.CONFIRMED, new, portal.world.now())
    # what the command leaves behind tells no place
    row = present.command
    told = json.dumps([row.args, row.result, row.progress, row.reason], default=str) + json.dumps(portal.rig.journal())
    for x, y in hidden(present).values():
        for value in (x, y, 1000 * x, 1000 * y):
            assert f"{value:.4f}"[:-1] not in told
    assert portal.robot.rig_secret not in told


def test_bury_again_reaches_the_sand(worlds, moderator, robot, monkeypatch):
    monkeypatch.setattr(MercuryRig, "secret", robot.rig_secret)
    hunt(worlds, 1, lambda portal: bury_again(portal, moderator))
