"""Promises 10, 11 and 12 in virtual time: bad lines, and faults of robots and cameras."""

import random

import pytest

from robots.models import Frame
from tests.conftest import BOTH_AT_LENGTH
from tests.world.motions import Motions
from tests.world.portal import ALL, EACH
from tests.world.seeds import hunt, seeds


@ALL
@seeds(1, 10, 60)
@pytest.mark.parametrize("how", ["noise", "pulled", "halved", "stalls"])
def test_promise_10_a_bad_line_causes_no_wrong_move(worlds, proof, seed, how):
    number = proof.count("commands", 6, 100)

    def run(portal):
        history, dice, rig = Motions(portal), random.Random(seed), portal.rig
        portal.grant()
        if how == "noise":
            for verb in ("drop", "corrupt", "double"):
                if verb in rig.faults:
                    rig.fault(verb, rig.strengths[verb] / 10)  # of each byte: longer lines take less of it
        asked, before = set(), set(history.begun)
        for _ in range(number):
            portal.ready_again()
            command = portal.move()
            asked.add(portal.wishes.goal(command))
            portal.world.sleep(dice.random() * 0.6)
            {"pulled": rig.pull, "halved": rig.halve, "stalls": lambda: rig.stall(dice.random() * 2)}.get(how, int)()
            portal.world.sleep(dice.random())
            rig.plug()
            portal.final(command)
        assert set(history.begun) <= asked | before, "the robot went where nobody sent it"
        history.check()

    hunt(worlds, seed, run)
    proof.holds(f"{how}: {number} commands, 0 wrong or doubled motions")


@EACH
@seeds(1, 10, 60)
def test_promise_11_every_command_ends(worlds, proof, seed):
    """Under each fault of robot and camera: a final state at most ten seconds after the limit, in words."""
    number, slowest = proof.count("faults, one after the other", 4, 10), [0.0]

    def run(portal):
        rig, wishes, dice = portal.rig, portal.wishes, random.Random(seed)
        portal.grant()
        for verb in dice.sample(wishes.faults, min(number, len(wishes.faults))):
            first = portal.move()
            portal.in_motion()
            rig.fault(verb, wishes.strengths.get(verb, 1.0))
            for command in (first, portal.move()):
                portal.final(command)
                took = (command.ended_at - (command.accepted_at or command.created_at)).total_seconds()
                assert took <= command.limit_s + 10.0, f"{command.state} after {took:.1f} s, under {verb}"
                assert command.state == "completed" or command.reason, command.state
                slowest[0] = max(slowest[0], took)
            rig.clear_faults()
            if portal.row.stop_latched:
                portal.release()
            portal.works_on()

    hunt(worlds, seed, run)
    proof.holds(f"{number} faults: every command ended, the slowest after {slowest[0]:.1f} s", slowest[0])


CAMERA = {
    "cam_freeze": "frozen", "cam_black": "black", "cam_flicker": "unstable", "cam_gone": None, "cam_slow": None, "cam_size": None,
}  # fmt: skip


@BOTH_AT_LENGTH
@seeds(1, 4, 10)
def test_promise_12_the_stability_check_always_answers(worlds, proof, seed):
    """Under each fault of a camera the motion is completed, in words that say what the picture is worth."""
    times, slowest = proof.count("answers a fault", 1, 5), [0.0]

    def run(portal):
        world = portal.world
        portal.grant()
        for verb, word in CAMERA.items():
            for _ in range(times):
                newest = Frame.objects.order_by("-id").first()
                portal.rig.fault(verb, {"cam_slow": 5.0, "cam_size": 0.5}.get(verb, 1.0))
                begun = world.monotonic()
                command = portal.final(portal.move(), 60)
                slowest[0] = max(slowest[0], world.monotonic() - begun)
                portal.rig.clear_faults()
                assert command.state == "completed", "a camera that fails does not undo the motion"
                verdict = command.result["verdict"]
                if word is not None and verb != "cam_flicker":
                    assert (verdict, command.result["stable"]) == (word, False)
                if verb in ("cam_gone", "cam_slow"):
                    assert verdict in ("no picture", "camera stopped")
                if verb == "cam_freeze":
                    frame = Frame.objects.order_by("-id").first()
                    assert frame.pk == newest.pk or not frame.stable, "a frozen picture counted as a new one"
                portal.until(
                    lambda: portal.final(portal.move()).result.get("stable"), 60, "a camera that is well again"
                )
        assert slowest[0] < 30

    hunt(worlds, seed, run)
    proof.holds(f"{times * len(CAMERA)} answers, slowest {slowest[0]:.1f} virtual s with the motion", slowest[0])
